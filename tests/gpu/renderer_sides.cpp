/// Which side of a surface is which, on the device and on the reference: vertex normals decide, mirrors mirror, and of
/// coincident surfaces the first is seen.

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <glm/gtc/matrix_transform.hpp>

#include "device_test.h"
#include "reference/reference_renderer.h"
#include "reference_scenes.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::box;
using reference::test::diffuse;
using reference::test::floor_scene;
using reference::test::quad;

class RendererSides : public DeviceTest {
 protected:
  struct Estimate {
    double mean, standard_error;
  };
  // Of the mean luminance of the picture.
  Estimate estimate(const Scene& scene, bool on_device, std::uint32_t samples, std::uint32_t seed = 5) {
    const RenderSettings settings{.seed = seed, .quantity = FilmQuantity::luminance};
    const std::unique_ptr<Renderer> renderer =
        on_device ? make_gpu_renderer(scene, settings, renderer_options()) : make_reference_renderer(scene, settings);
    Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
    std::vector<RejectedSample> rejected;
    renderer->render({0, samples}, film, {}, rejected);
    EXPECT_EQ(film.rejected(), 0u);
    const Moments m = film_moments(film, 0);
    return {static_cast<double>(m.mean), static_cast<double>(std::sqrt(m.variance / static_cast<long double>(m.n)))};
  }
};

constexpr double kMaxT = 4.8;  // |t| of a correct estimator exceeds it once in a million

void give_normals(TriangleMesh& mesh, const glm::dvec3& n) {
  mesh.normals = std::vector<glm::dvec3>(mesh.positions.size(), n);
}

// A lamp over the floor that shines down by its winding, its vertex normals, or both.
Scene lamp_scene(bool winding_down, std::optional<glm::dvec3> normal, bool tree) {
  Scene scene = floor_scene(0.5);
  TriangleMesh lamp =
      winding_down ? quad({-0.5, 1, -0.5}, {1, 0, 0}, {0, 0, 1}) : quad({-0.5, 1, -0.5}, {0, 0, 1}, {1, 0, 0});
  if (normal) give_normals(lamp, *normal);
  add(scene, lamp, diffuse(0.0), glm::dvec3(1.0));
  scene.integrator.light_sampler = tree ? Integrator::LightSampler::tree : Integrator::LightSampler::power;
  return scene;
}

TEST_F(RendererSides, VertexNormalsDecideWhereALampShines) {
  const glm::dvec3 down(0, -1, 0), up(0, 1, 0);
  for (const bool on_device : {true, false}) {
    for (const bool tree : {false, true}) {
      const Estimate lit = estimate(lamp_scene(true, std::nullopt, tree), on_device, 4096);
      EXPECT_GT(lit.mean, 0.01);
      for (const bool winding_down : {true, false}) {
        SCOPED_TRACE(std::string(on_device ? "device" : "reference") + (tree ? ", tree" : "") +
                     (winding_down ? ", winding down" : ", winding up"));
        const Estimate by_normals = estimate(lamp_scene(winding_down, down, tree), on_device, 4096);
        EXPECT_LT(std::abs(by_normals.mean - lit.mean),
                  kMaxT * std::hypot(by_normals.standard_error, lit.standard_error));
        EXPECT_EQ(estimate(lamp_scene(winding_down, up, tree), on_device, 256).mean, 0.0);
      }
      EXPECT_EQ(estimate(lamp_scene(false, std::nullopt, tree), on_device, 256).mean, 0.0);
    }
  }
}

// Light sampling and hits by chance must agree where the normals of a lamp vary and disagree with its winding.
TEST_F(RendererSides, StrategiesAgreeOnALampOfBentNormals) {
  for (const bool on_device : {true, false}) {
    for (const bool tree : {false, true}) {
      Scene scene = lamp_scene(false, glm::dvec3(0, -1, 0), tree);
      auto& lamp = std::get<TriangleMesh>(scene.shapes.back());
      for (std::size_t i = 0; i < lamp.normals.size(); ++i)
        lamp.normals.edit()[i] =
            glm::normalize(glm::dvec3(lamp.positions[i].x * 1.5, -0.25, lamp.positions[i].z * 1.5));
      std::vector<Estimate> estimates;
      for (const auto& [nee, mis] : {std::pair(false, false), std::pair(true, false), std::pair(true, true)}) {
        scene.integrator.nee = nee;
        scene.integrator.mis = mis;
        estimates.push_back(estimate(scene, on_device, 60000));
      }
      for (const Estimate& e : estimates) {
        EXPECT_LT(std::abs(e.mean - estimates.back().mean),
                  kMaxT * std::hypot(e.standard_error, estimates.back().standard_error))
            << on_device << tree << ' ' << e.mean << " against " << estimates.back().mean;
      }
    }
  }
}

// A room with a lamp, a glass ball and a box turned by its normals, looked into from a corner.
Scene room() {
  Scene scene;
  scene.camera.width = scene.camera.height = 24;
  scene.camera.fov = 70.0;
  scene.camera.world_from_camera =
      glm::inverse(glm::lookAt(glm::dvec3(0.8, 0.6, 0.9), glm::dvec3(-0.2, -0.3, 0), glm::dvec3(0, 1, 0))) *
      glm::scale(glm::dmat4(1.0), glm::dvec3(-1, 1, -1));
  add(scene, box({-1, -1, -1}, {1, 1, 1}, true), diffuse(0.6));
  add(scene, quad({-0.4, 0.95, -0.4}, {0.8, 0, 0}, {0, 0, 0.5}), diffuse(0.0), glm::dvec3(3.0, 2.0, 1.0));
  add(scene, Sphere{{-0.5, -0.7, 0.1}, 0.3}, DielectricBsdf{});
  TriangleMesh block = box({0, -1, -0.6}, {0.5, -0.3, -0.2}, false);
  for (glm::uvec3& t : block.triangles) std::swap(t.y, t.z);  // wound against its normals
  for (const glm::dvec3& p : block.positions)
    block.normals.push_back(glm::normalize(p - glm::dvec3(0.25, -0.65, -0.4)));
  add(scene, block, diffuse(0.8));
  scene.integrator.max_depth = 6;
  return scene;
}

Scene moved(Scene scene, const glm::dmat4& world_from_world) {
  for (Instance& instance : scene.instances) instance.world_from_object = world_from_world * instance.world_from_object;
  scene.camera.world_from_camera = world_from_world * scene.camera.world_from_camera;
  return scene;
}

// The camera is moved along, so each picture must be that of the scene itself.
TEST_F(RendererSides, TurnedAndMirroredScenesGiveTheSamePicture) {
  const glm::dmat4 one(1.0);
  const std::vector<std::pair<const char*, glm::dmat4>> motions = {
      {"turned", glm::rotate(one, 0.7, glm::dvec3(1, 2, 3))},
      {"mirrored in x", glm::scale(one, glm::dvec3(-1, 1, 1))},
      {"mirrored, turned and doubled",
       glm::scale(glm::rotate(one, 2.0, glm::dvec3(3, -1, 2)), glm::dvec3(2.0, -2.0, 2.0))},
      {"turned inside out twice", glm::scale(one, glm::dvec3(-1, -1, -1))}};
  for (const bool on_device : {true, false}) {
    const std::uint32_t samples = on_device ? 400 : 60;
    const Estimate original = estimate(room(), on_device, samples);
    EXPECT_GT(original.mean, 0.05);
    for (const auto& [name, motion] : motions) {
      const Estimate e = estimate(moved(room(), motion), on_device, samples, 6);
      EXPECT_LT(std::abs(e.mean - original.mean), kMaxT * std::hypot(e.standard_error, original.standard_error))
          << (on_device ? "device, " : "reference, ") << name << ": " << e.mean << " against " << original.mean;
      EXPECT_LT(e.standard_error, 0.03 * original.mean) << "too noisy to tell";
    }
  }
}

TEST_F(RendererSides, FlippedNormalsTurnALamp) {
  for (const bool on_device : {true, false}) {
    for (const bool normals : {false, true}) {
      Scene scene = lamp_scene(false, normals ? std::optional(glm::dvec3(0, 1, 0)) : std::nullopt, false);
      EXPECT_EQ(estimate(scene, on_device, 64).mean, 0.0);
      scene.instances.back().flip_normals = true;
      EXPECT_GT(estimate(scene, on_device, 64).mean, 0.01);
    }
  }
}

// Lamps in one plane, of radiances 1, 2, …, look like the first of them; with other triangles around, in or outside the
// tree, and whatever the order in which it is walked.
TEST_F(RendererSides, TheFirstOfCoincidentSurfacesIsSeen) {
  for (const bool on_device : {true, false}) {
    for (const int others : {0, 100}) {
      for (const double first : {1.0, 3.0}) {
        Scene scene;
        scene.camera.width = scene.camera.height = 16;
        scene.camera.fov = 20.0;
        scene.integrator.max_depth = 1;
        for (int i = 0; i < others / 2; ++i)
          add(scene, quad({0.2 * i - 3, -4, 5}, {0.1, 0, 0}, {0, 0.1, 0}), diffuse(0.5));
        for (int i = 0; i < 3; ++i) {
          const double radiance = first + (first > 2.0 ? -i : i);
          add(scene, quad({-2, -2, 4}, {0, 4, 0}, {4, 0, 0}), diffuse(0.0), glm::dvec3(radiance));
        }
        for (int i = 0; i < others / 2; ++i)
          add(scene, quad({0.2 * i - 3, 4, 5}, {0.1, 0, 0}, {0, 0.1, 0}), diffuse(0.5));
        const Estimate e = estimate(scene, on_device, 16);
        EXPECT_NEAR(e.mean, first, 1e-6) << (on_device ? "device" : "reference") << ", " << others << " others";
        EXPECT_NEAR(e.standard_error, 0.0, 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace etendue::test
