/// Builds a scene in memory, renders it on a Vulkan device and by the reference renderer, and compares the pictures.
///
///     two_devices [DEVICE [SAMPLES]]      DEVICE as in `etendue devices`; writes two_devices.exr

#include <cstdlib>
#include <iostream>
#include <string>

#include <etendue/etendue.h>

namespace {

/// A diffuse sphere on a floor, under a square lamp and a blue sky.
etendue::Scene make_scene() {
  etendue::Scene scene;
  scene.name = "two_devices";
  scene.camera.width = 64;
  scene.camera.height = 48;
  scene.camera.fov = 40.0;  // degrees, horizontal
  // The camera looks along +z of its own space; it stands 4 behind the sphere and 1 above the floor.
  scene.camera.world_from_camera[3] = glm::dvec4(0.0, 1.0, -4.0, 1.0);
  scene.sampler.sample_count = 64;
  scene.integrator.max_depth = 6;
  scene.sky.top = glm::dvec3(0.1, 0.15, 0.3);
  scene.sky.horizon = glm::dvec3(0.3);

  scene.add(etendue::Sphere{.center = {0.0, 0.7, 0.0}, .radius = 0.7}, etendue::DiffuseBsdf{.albedo = {0.7, 0.3, 0.2}});

  // Triangles are counter-clockwise as seen from the side their normal points to.
  etendue::TriangleMesh floor;
  floor.positions = {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
  floor.triangles = {{0, 2, 1}, {0, 3, 2}};
  scene.add(floor, etendue::DiffuseBsdf{.albedo = glm::dvec3(0.6)});

  // The lamp is the unit square, placed: it looks down, and so does its light.
  etendue::TriangleMesh square;
  square.positions = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  etendue::Instance& lamp = scene.add(square, etendue::DiffuseBsdf{.albedo = glm::dvec3(0.0)},
                                      etendue::AreaEmitter{.radiance = glm::dvec3(6.0)});
  lamp.world_from_object[3] = glm::dvec4(0.0, 3.0, 0.0, 1.0);
  lamp.name = "lamp";
  return scene;
}

int run(const std::string& device, std::uint32_t samples) {
  const etendue::Scene made = make_scene();
  const etendue::SharedScene scene(made);  // what a device needs of it is compiled once
  // Other seeds, so that the two pictures are independent of each other: what the tests of compare_images ask for.
  const etendue::FilmFile test =
      etendue::render(scene, {.devices = {.selector = device}, .seed = 1, .samples = samples});
  const etendue::FilmFile reference =
      etendue::render(scene, {.devices = {.selector = "reference"}, .seed = 2, .samples = samples});
  const etendue::Image picture = etendue::picture_of(test);
  etendue::write_exr("two_devices.exr", picture);

  // A renderer of one's own tells single samples: the same seed gives the same path on every device.
  const auto on_device = etendue::open_renderer(scene, {.selector = device});
  const auto on_host = etendue::open_renderer(scene, {.selector = "reference"});
  const etendue::SampleId middle{.pixel = 24 * 64 + 32, .sample = 0};
  const auto a = on_device->trace_samples({&middle, 1}).front(), b = on_host->trace_samples({&middle, 1}).front();
  std::cout << "One path: " << a.segments << " and " << b.segments << " segments on " << on_device->device_name()
            << " and " << on_host->device_name() << ".\n";

  const etendue::Comparison comparison =
      etendue::compare_images(picture, device, etendue::picture_of(reference), "reference");
  std::cout << "The pictures are " << etendue::verdict_name(comparison.verdict) << ".\n";
  return comparison.passed() && a.segments == b.segments ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  const etendue::TerminalLog messages;  // to stderr; without it the library is silent
  try {
    return run(argc > 1 ? argv[1] : "auto", argc > 2 ? static_cast<std::uint32_t>(std::stoul(argv[2])) : 0);
  } catch (const etendue::Error& error) {
    etendue::log::error(error.what());
    return error.kind() == etendue::ErrorKind::device ? 77 : 2;
  } catch (const std::exception& error) {
    etendue::log::error(error.what());
    return 2;
  }
}
