/// L2 of the equality contract: the device and the double-precision reference trace the same paths from the same random
/// numbers.

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "compile/compiled_scene.h"
#include "core/errors.h"
#include "device_test.h"
#include "formats/read_scene.h"
#include "reference/reference_renderer.h"
#include "reference_scenes.h"
#include "sky_pictures.h"
#include "validate/sample_comparison.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::diffuse;
using reference::test::quad;

class RendererAgreement : public DeviceTest {
 protected:
  // About `budget` samples of both; `flips` and `off` bound what is allowed per million.
  void compare(const std::string& what, const Scene& scene, std::uint64_t budget, double flips, double off) {
    const auto device = make_gpu_renderer(scene, {.seed = 11}, renderer_options());
    const auto reference = make_reference_renderer(scene, {.seed = 11});
    const SampleComparison c = compare_samples(*device, *reference, scene.camera.width, scene.camera.height, budget);
    std::string where;
    for (const auto& [difference, count] : c.first_differences) where += fmt::format("\n  {} × {}", count, difference);
    SCOPED_TRACE(fmt::format(
        "{}: {} samples, {:.0f} flips and {:.0f} off per million, relative error median {:.2g}, 99.9 % {:.2g}, largest "
        "{:.2g}{}",
        what, c.samples, c.flips_per_million(), c.off_per_million(), c.median_error, c.p999_error, c.max_error, where));
    EXPECT_GE(c.samples, budget / 2);
    EXPECT_EQ(c.non_finite, 0u);
    EXPECT_LE(c.flips_per_million(), flips);
    EXPECT_LE(c.off_per_million(), off);
    EXPECT_LT(c.median_error, 5e-5);
    // Paired, even a systematic rounding of 1e-5 is significant; only more than rounding counts.
    EXPECT_TRUE(c.same_mean() || std::abs(c.paired.mean - c.paired.reference) < 1e-4 * std::abs(c.paired.reference))
        << "paired p = " << c.paired.p_value;
    RecordProperty(what + "_flips_per_million", std::to_string(c.flips_per_million()));
    RecordProperty(what + "_off_per_million", std::to_string(c.off_per_million()));
    RecordProperty(what + "_p999_error", std::to_string(c.p999_error));
  }
};

// Shines down at a slant.
glm::dmat4 oblique_light(const glm::dvec3& at) {
  const glm::dvec3 z = glm::normalize(glm::dvec3(0.2, -1.0, -0.3)), x = glm::normalize(glm::cross({0, 0, 1}, z));
  return glm::dmat4(glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0), glm::dvec4(z, 0), glm::dvec4(at, 1));
}

Scene cornell(std::vector<std::pair<std::string, std::string>> overrides) {
  overrides.insert(overrides.end(), {{"camera.width", "100"}, {"camera.height", "75"}});
  return read_scene(SCENES_DIR "/cbox-sphere.xml", {.overrides = std::move(overrides), .strict = true});
}

TEST_F(RendererAgreement, CornellBoxInAllStrategies) {
  compare("naive", cornell({{"integrator.nee", "false"}}), 60000, 500, 300);
  compare("nee", cornell({{"integrator.mis", "false"}}), 60000, 500, 300);
  compare("mis", cornell({}), 60000, 500, 300);
}

TEST_F(RendererAgreement, DepthRouletteAndNormals) {
  compare("depth 1", cornell({{"integrator.maxDepth", "1"}}), 30000, 200, 0);
  compare("depth 2", cornell({{"integrator.maxDepth", "2"}}), 30000, 300, 100);
  compare("no roulette", cornell({{"integrator.rrDepth", "0"}}), 30000, 600, 300);
  compare("roulette from the first segment", cornell({{"integrator.rrDepth", "1"}}), 30000, 600, 300);
  Scene normals = cornell({});
  normals.integrator.type = Integrator::Type::normals;
  compare("normals", normals, 30000, 200, 0);
}

TEST_F(RendererAgreement, IntegratorsOfTheCourses) {
  const auto as = [](Integrator::Type type) {
    Scene scene = cornell({});
    scene.integrator.type = type;
    return scene;
  };
  using Type = Integrator::Type;
  for (const auto& [emitter, bsdf] : {std::pair(1u, 1u), {3u, 2u}, {2u, 0u}, {0u, 3u}}) {
    Scene direct = as(Type::direct);
    direct.integrator.emitter_samples = emitter;
    direct.integrator.bsdf_samples = bsdf;
    compare(fmt::format("direct {} {}", emitter, bsdf), direct, 20000, 600, 400);
  }
  Scene hidden = as(Type::path);
  hidden.integrator.hide_emitters = true;
  compare("hidden emitters", hidden, 20000, 600, 400);
  compare("whitted", as(Type::whitted), 20000, 600, 400);
  compare("absolute normals", as(Type::absolute_normals), 20000, 200, 0);
  compare("depth", as(Type::depth), 20000, 200, 0);
  compare("distance", as(Type::distance), 20000, 200, 0);
  Scene simple = as(Type::simple);
  simple.integrator.light = {{0.1, 0.6, 0.2}, {40, 30, 20}};
  compare("simple", simple, 20000, 600, 400);
  for (const Type type : {Type::ambient_occlusion, Type::visibility}) {
    for (const double length : {0.3, 1e30}) {
      Scene scene = as(type);
      scene.integrator.length = length;
      compare(fmt::format("openness {} {}", static_cast<int>(type), length), scene, 20000, 800, 400);
    }
  }
}

// Smooth normals, a hollow glass sphere, several lamps of different shape, sky.
Scene everything() {
  Scene scene;
  scene.camera.width = 64;
  scene.camera.height = 48;
  scene.camera.fov = 50.0;
  scene.camera.world_from_camera = reference::test::look_at({0, 1.5, 5}, {0, 0.6, 0}, {0, 1, 0});
  scene.integrator.max_depth = 10;
  scene.sky = {.top = {0.2, 0.4, 0.9}, .horizon = {0.8, 0.7, 0.6}};
  add(scene, quad({-20, 0, -20}, {0, 0, 40}, {40, 0, 0}), DiffuseBsdf{{0.6, 0.5, 0.4}});
  add(scene, Sphere{{-1.2, 0.6, 0}, 0.6}, DielectricBsdf{});
  add(scene, Sphere{{-1.2, 0.6, 0}, 0.55}, DielectricBsdf{.int_ior = 1.000277, .ext_ior = 1.5046});
  add(scene, Sphere{{1.2, 0.6, 0.3}, 0.6}, MirrorBsdf{});
  add(scene, Sphere{{0.1, 2.5, -0.5}, 0.3}, diffuse(0.3), glm::dvec3(9, 8, 6));
  add(scene, quad({-3, 0.5, -3}, {2, 0, 0}, {0, 2, 0}), diffuse(0.5), glm::dvec3(1, 2, 3));
  // A tetrahedron with the normals of its circumsphere.
  TriangleMesh smooth;
  for (const glm::dvec3& d :
       {glm::dvec3(1, 1, 1), glm::dvec3(-1, -1, 1), glm::dvec3(-1, 1, -1), glm::dvec3(1, -1, -1)}) {
    smooth.positions.push_back(glm::dvec3(0.1, 0.7, 0.9) + 0.4 * d);
    smooth.normals.push_back(glm::normalize(d));
  }
  smooth.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  add(scene, smooth, DiffuseBsdf{{0.2, 0.7, 0.3}});
  return scene;
}

TEST_F(RendererAgreement, Cameras) {
  using Type = Camera::Type;
  for (const Type type :
       {Type::thin_lens, Type::orthographic, Type::spherical, Type::radiance_meter, Type::irradiance_meter}) {
    Scene scene = cornell({});
    scene.camera.type = type;
    scene.camera.aperture = {.radius = 0.1, .focus_distance = 3.5, .blades = type == Type::thin_lens ? 6u : 0u};
    scene.camera.window.origin = {0.1, 0.2};
    scene.camera.window.size = {0.6, 0.7};
    if (type == Type::irradiance_meter) scene.camera.near_clip = 0.05;
    compare(fmt::format("camera {}", static_cast<int>(type)), scene, 20000, 800, 500);
  }
  // Sets of a lens, and a lens so far away that its rays begin before the scene.
  Scene far = everything();
  far.camera.type = Type::thin_lens;
  far.camera.world_from_camera = reference::test::look_at({0, 3e3, 1e4}, {0, 0.6, 0}, {0, 1, 0});
  far.camera.fov = 180.0 / std::numbers::pi * 6.0 / 1e4;
  far.camera.far_clip = 1e9;
  far.camera.aperture = {.radius = 1e3, .focus_distance = 1.05e4};
  far.sampler = {Sampler::Type::sobol, 16, 4};
  compare("far lens", far, 20000, 1000, 800);
}

// One sample of each kind is what path takes at its first vertex, to the bit.
TEST_F(RendererAgreement, DirectIsPathOfTwoSegments) {
  Scene path = cornell({{"integrator.maxDepth", "2"}, {"integrator.rrDepth", "0"}});
  Scene direct = path;
  direct.integrator.type = Integrator::Type::direct;
  std::vector<SampleId> ids;
  for (std::uint32_t i = 0; i < 7500; ++i) ids.push_back({i, i % 5});
  const auto by_path = make_gpu_renderer(path, {.seed = 4}, renderer_options())->trace_samples(ids);
  const auto by_direct = make_gpu_renderer(direct, {.seed = 4}, renderer_options())->trace_samples(ids);
  const auto reference = make_reference_renderer(path, {.seed = 4})->trace_samples(ids);
  const auto reference_direct = make_reference_renderer(direct, {.seed = 4})->trace_samples(ids);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    ASSERT_EQ(by_path[i].radiance, by_direct[i].radiance) << i;
    ASSERT_EQ(by_path[i].signature, by_direct[i].signature) << i;
    ASSERT_EQ(reference[i].radiance, reference_direct[i].radiance) << i;
    ASSERT_EQ(reference[i].signature, reference_direct[i].signature) << i;
  }
}

TEST_F(RendererAgreement, FiltersAndMirroredCameras) {
  for (const auto type : {ReconstructionFilter::Type::tent, ReconstructionFilter::Type::gaussian,
                          ReconstructionFilter::Type::mitchell, ReconstructionFilter::Type::lanczos}) {
    Scene scene = cornell({});
    scene.camera.filter.type = type;
    scene.camera.world_from_camera[0] *= -1.0;
    compare("filter " + std::to_string(static_cast<int>(type)), scene, 20000, 600, 400);
  }
}

TEST_F(RendererAgreement, CourseTests) {
  for (const char* file : {"ttest-furnace.xml", "ttest-direct.xml"}) {
    const auto test = std::get<TTest>(read_scene_file(std::string(SCENES_DIR "/") + file));
    for (std::size_t i = 0; i < test.scenes.size(); ++i) {
      Scene scene = test.scenes[i];
      // The camera of the direct test stares at the diagonal between the floor's two triangles, where rounding decides
      // which one is hit.
      if (scene.camera.fov < 1.0) scene.camera.world_from_camera[3] += glm::dvec4(0.013, 0.0, 0.007, 0.0);
      compare(fmt::format("{} {}", file, i + 1), scene, 5000, 1200, 600);
    }
  }
}

TEST_F(RendererAgreement, ManyMaterialsSmoothNormalsAndSky) {
  compare("everything", everything(), 60000, 800, 600);
}

// Glass that colours what it reflects and lets pass, one by a texture, and coats that are rough in places.
TEST_F(RendererAgreement, TintedGlassAndVaryingCoats) {
  Scene scene = everything();
  scene.textures.push_back({.source = CheckerboardTexture{glm::dvec3(0.1, 0.4, 0.9), glm::dvec3(0.8, 0.6, 0.3)}});
  const auto texture = static_cast<std::uint32_t>(scene.textures.size() - 1);
  for (Material& material : scene.materials) {
    if (auto* glass = std::get_if<DielectricBsdf>(&material.bsdf))
      glass->specular_transmittance = {{0.9, 0.7, 1.0}, texture};
  }
  RoughPlasticBsdf coat{.diffuse_reflectance = glm::dvec3(0.7, 0.3, 0.2), .alpha = {1.0, texture, TextureChannel::red}};
  add(scene, Sphere{{0.3, 0.4, 1.2}, 0.4}, coat);
  coat.distribution = Roughness::Distribution::ggx;
  coat.nonlinear = true;
  add(scene, Sphere{{1.4, 0.35, 0.9}, 0.35}, coat);
  add(scene, Sphere{{-0.4, 0.3, 1.4}, 0.3}, DielectricBsdf{1.5, 1.0, glm::dvec3(0.5), glm::dvec3(0.9, 0.8, 0.2)});
  compare("tinted", scene, 60000, 800, 600);
}

// Under pictures of the sky with a sun in them, texels next to each other as different as can be: what glass and
// mirrors make of a rounding error is seen; lamps chosen by power and by their tree, Sobol points, no other light at
// all.
TEST_F(RendererAgreement, PicturesOfTheSky) {
  Scene scene = everything();
  scene.sky.picture = make_random_sky(31, 17, SkyPicture::Rows::bands);
  scene.sky.world_from_sky = oblique_turn();
  compare("beside lamps", scene, 40000, 800, 2000);
  scene.sampler = {Sampler::Type::sobol, 16, 4};
  scene.integrator.light_sampler = Integrator::LightSampler::tree;
  compare("beside a tree of lamps, sobol", scene, 40000, 800, 2000);
  scene.integrator.mis = false;
  compare("without mis", scene, 20000, 800, 2000);
  Scene alone = everything();
  for (Instance& instance : alone.instances) instance.emitter.reset();
  alone.sky.picture = make_random_sky(64, 32, SkyPicture::Rows::circles, 1e4f);
  compare("alone", alone, 40000, 800, 2000);
}

// All kinds of lights without extent, few by power and many by the tree, beside lamps and a sky, on glossy and diffuse
// surfaces.
Scene under_points(int copies) {
  Scene scene = everything();
  const auto put = [&](DeltaLight::Type type, const glm::dvec3& at, const glm::dvec3& color) -> DeltaLight& {
    DeltaLight& light = scene.delta_lights.emplace_back(DeltaLight{.type = type, .intensity = color});
    light.world_from_light = oblique_light(at);
    return light;
  };
  for (int i = 0; i < copies; ++i) {
    const double shift = 0.3 * i;
    put(DeltaLight::Type::point, {0.5 - shift, 1.5, 1.0}, {1.0, 0.8, 0.6});
    DeltaLight& spot = put(DeltaLight::Type::spot, {-1.0 + shift, 2.5, 0.5}, {3.0, 4.0, 5.0});
    spot.cutoff = 50.0;
    spot.beam_width = 10.0;
    spot.falloff = static_cast<DeltaLight::Falloff>(i % 3);
    put(DeltaLight::Type::projector, {0.0, 2.0, -1.0 + shift}, {2.0, 1.0, 1.0}).slope = {0.8, 1.1};
  }
  put(DeltaLight::Type::directional, {0, 0, 0}, {0.5, 0.5, 0.4});
  put(DeltaLight::Type::directional, {0, 0, 0}, {0.1, 0.2, 0.4});
  return scene;
}

TEST_F(RendererAgreement, LightsWithoutExtent) {
  compare("a few", under_points(1), 40000, 800, 1000);
  Scene many = under_points(4);
  many.integrator.light_sampler = Integrator::LightSampler::tree;
  compare("a tree of them", many, 40000, 800, 1000);
  many.integrator.mis = false;
  many.sky = {};
  many.sampler = {Sampler::Type::sobol, 16, 4};
  compare("a tree of them without mis or sky, sobol", many, 20000, 800, 1000);
  Scene alone = under_points(1);
  for (Instance& instance : alone.instances) instance.emitter.reset();
  alone.sky = {};
  alone.integrator.type = Integrator::Type::whitted;
  compare("alone, whitted", alone, 20000, 800, 1000);
  std::erase_if(alone.delta_lights, [](const DeltaLight& l) { return l.type != DeltaLight::Type::directional; });
  compare("directions alone", alone, 20000, 800, 1000);
}

// The same scene at another size and place. Coordinates are doubles on both sides, so only the rounding of the inputs
// differs.
Scene placed(Scene scene, double scale, const glm::dvec3& offset) {
  const glm::dmat4 motion = glm::scale(glm::translate(glm::dmat4(1.0), offset), glm::dvec3(scale));
  for (Instance& instance : scene.instances) instance.world_from_object = motion * instance.world_from_object;
  glm::dvec4& origin = scene.camera.world_from_camera[3];
  origin = glm::dvec4(glm::dvec3(origin) * scale + offset, 1.0);
  scene.camera.near_clip *= scale;
  scene.camera.far_clip *= scale;
  return scene;
}

// Disks under shears and mirrors, cylinders seen from both sides, lamps among them; more than stand outside the tree
// when `crowd` is.
Scene round_shapes(bool crowd) {
  Scene scene = everything();
  scene.instances.resize(1);  // the ground
  const auto put = [&](Shape shape, Bsdf bsdf, const glm::dmat4& m,
                       std::optional<glm::dvec3> radiance = {}) -> Instance& {
    Instance& instance = add(scene, std::move(shape), bsdf, radiance);
    instance.world_from_object = m;
    return instance;
  };
  const glm::dmat4 one(1.0);
  const auto at = [&](double x, double y, double z) { return glm::translate(one, {x, y, z}); };
  glm::dmat4 shear(1.0);
  shear[1][0] = 0.7;
  shear[2][1] = -0.4;
  put(Disk{}, diffuse(0.6), at(-1.2, 1.0, -0.5) * glm::rotate(one, 0.6, {1, 1, 0}) * shear);
  put(Disk{}, diffuse(0.4), at(1.6, 0.7, 0.2) * glm::scale(one, {-0.8, 0.3, 2.0}) * shear, glm::dvec3(2, 3, 4));
  put(Disk{}, diffuse(0.5), at(0, 3, 0) * glm::rotate(one, 1.4, {1, 0, 0}) * glm::scale(one, {0.9, 0.4, 1.0}),
      glm::dvec3(9, 8, 6));
  const Cylinder tube{{0, 0, 0}, {0, 1, 0}, 0.4};
  put(tube, diffuse(0.7), at(0.2, 0, 0.9));
  put(tube, MirrorBsdf{}, at(-1.5, 0, 1.2) * glm::rotate(one, 0.4, {0, 0, 1}) * glm::scale(one, glm::dvec3(-1.2)));
  put(Cylinder{{-0.5, 0, 0}, {0.5, 0.2, 0.1}, 0.1}, diffuse(0.5), at(0.4, 1.5, 1.0), glm::dvec3(5, 4, 3));
  put(Cylinder{{0, 0, 0}, {0, 0.5, 0}, 0.39}, diffuse(0.5), at(0.2, 0.2, 0.9), glm::dvec3(1, 2, 1)).flip_normals = true;
  for (int i = 0; crowd && i < 40; ++i) {
    const glm::dmat4 place = at(-2 + 0.1 * i, 0.1 + 0.02 * i, -1.5) * glm::rotate(one, 0.3 * i, {1, 2, 3});
    put(i % 2 == 0 ? Shape(Disk{}) : Shape(Cylinder{{0, 0, 0}, {0, 0, 2}, 0.5}), diffuse(0.5),
        place * glm::scale(one, glm::dvec3(0.1)), i % 5 == 0 ? std::optional(glm::dvec3(i, 4, 3)) : std::nullopt);
  }
  return scene;
}

TEST_F(RendererAgreement, DisksAndCylinders) {
  for (const bool crowd : {false, true}) {
    const Scene scene = round_shapes(crowd);
    compare(crowd ? "crowd" : "few", scene, 40000, 1200, 800);
    compare("1e-4", placed(scene, 1e-4, {0, 0, 0}), 10000, 1000, 800);
    compare("far away", placed(scene, 1.0, {3e5, -1e5, 7e5}), 10000, 1000, 800);
  }
}

// Metal that is brushed along the texture coordinates of what it lies on, in a room that shines inward.
TEST_F(RendererAgreement, BrushedMetalAndInwardSpheres) {
  Scene scene = round_shapes(false);
  const RoughConductorBsdf brushed{.index = {},
                                   .roughness = {Roughness::Distribution::ggx, 0.5, 0.06},
                                   .specular_reflectance = glm::dvec3(0.9, 0.7, 0.5)};
  const glm::dmat4 turn = glm::rotate(glm::dmat4(1.0), 0.9, {1.0, 0.4, 0.2});
  for (const bool inward : {false, true}) {
    Instance& ball = add(scene, Sphere{{inward ? 0.4 : -0.6, 0.5, 1.5}, 0.35}, brushed);
    ball.world_from_object = turn;
    ball.flip_normals = inward;
  }
  for (Instance& instance : scene.instances) {
    if (!std::holds_alternative<TriangleMesh>(scene.shape_of(instance)) && !instance.emitter)
      scene.materials[instance.material].bsdf = brushed;
  }
  Instance& room = add(scene, Sphere{{0, 0, 0}, 12.0}, diffuse(0.5), glm::dvec3(0.5, 0.6, 0.7));
  room.flip_normals = true;
  compare("brushed, inward", scene, 20000, 1200, 800);
  scene.integrator.light_sampler = Integrator::LightSampler::tree;
  compare("by the tree", scene, 20000, 1200, 800);
}

// Waves of normals, 8 × 8 texels.
std::shared_ptr<Bitmap> waves() {
  auto bitmap = std::make_shared<Bitmap>();
  *bitmap = {.width = 8, .height = 8, .channels = 3, .format = BitmapFormat::f32, .color_space = ColorSpace::linear};
  for (int i = 0; i < 64; ++i) {
    const glm::vec3 c(0.5 + 0.2 * std::sin(i), 0.5 + 0.2 * std::cos(1.3 * i), 0.95);
    const auto* bytes = reinterpret_cast<const std::byte*>(&c);
    bitmap->texels.insert(bitmap->texels.end(), bytes, bytes + sizeof c);
  }
  return bitmap;
}

// A mesh of a few bent triangles that has everything: coordinates, colours, alpha, normals and tangents of either side.
TriangleMesh bent_mesh() {
  TriangleMesh mesh;
  auto& uvs = mesh.uv_sets.emplace_back();
  constexpr int kSide = 9;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double u = 2.0 * x / (kSide - 1) - 1.0, v = 2.0 * y / (kSide - 1) - 1.0;
      mesh.positions.emplace_back(u, v, 0.3 * std::cos(2.0 * u) * std::cos(v));
      mesh.normals.push_back(glm::normalize(
          glm::dvec3(0.6 * std::sin(2.0 * u) * std::cos(v), 0.3 * std::cos(2.0 * u) * std::sin(v), 1.0)));
      uvs.emplace_back(1.5 * u, v);
      mesh.vertex_colors.emplace_back(0.5 + 0.5 * u, 0.7, 0.5 - 0.5 * v);
      mesh.vertex_alphas.push_back(static_cast<float>(0.5 + 0.5 * u * v));
      mesh.tangents.emplace_back(0.9, 0.3 * v, 0.2 * u, x < kSide / 2 ? 1.0 : -1.0);
    }
  }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t i = y * kSide + x;
      mesh.triangles.emplace_back(i, i + 1, i + kSide + 1);
      mesh.triangles.emplace_back(i, i + kSide + 1, i + kSide);
    }
  }
  return mesh;
}

// Instances of the mesh, upright, mirrored and turned, of a material that is made of a base by `finish`.
template <typename Finish>
Scene bent_meshes(Instancing instancing, const GltfBsdf& base, const Finish& finish) {
  Scene scene = everything();
  scene.instancing = instancing;
  scene.bitmaps.push_back(waves());
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0}, .name = "waves"});
  const glm::dmat4 one(1.0), here = glm::translate(one, {0.4, 1.0, 1.6}) * glm::scale(one, glm::dvec3(0.7));
  Instance first = scene.add(bent_mesh(), base);
  scene.instances.pop_back();
  first.material = finish(scene, first.material);
  for (const glm::dmat4& place : {here, glm::translate(one, {-1.4, 1.2, 0.9}) * glm::scale(one, {-0.6, 0.6, 0.6}),
                                  glm::translate(one, {1.5, 1.7, 0.4}) * glm::rotate(one, 2.5, {0.3, 1.0, 0.1}) *
                                      glm::scale(one, {0.5, 0.8, 0.4})}) {
    Instance instance = first;
    instance.world_from_object = place;
    scene.instances.push_back(instance);
  }
  scene.instances.back().flip_normals = true;
  return scene;
}

std::uint32_t add_material(Scene& scene, Adapter adapter) {
  scene.materials.push_back({.adapter = std::move(adapter)});
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

TEST_F(RendererAgreement, TangentsTintsAndCoats) {
  const GltfBsdf lacquer{
      .base_color = {0.7, 0.4, 0.2}, .metallic = 0.3, .roughness = 0.6, .clearcoat = 0.8, .clearcoat_roughness = 0.4};
  for (const Instancing instancing : {Instancing::never, Instancing::always}) {
    const std::string where = instancing == Instancing::always ? ", shared" : "";
    for (const bool own : {false, true}) {
      const Scene bent = bent_meshes(instancing, lacquer, [&](Scene& scene, std::uint32_t row) {
        auto& coated = std::get<GltfBsdf>(scene.materials[row].bsdf);
        coated.coat_keeps_normal = true;
        coated.coat_vertex_tangents = own;
        if (own) coated.coat_normals.texture = std::uint32_t{0};
        row = add_material(scene, NormalMapAdapter{{glm::dvec3(1.0), 0}, row, true});
        return add_material(scene, TwoSidedAdapter{row, row});
      });
      compare((own ? "coat's map" : "smooth coat") + where, bent, 20000, 1500, 1500);
    }
    const GltfBsdf brushed{.roughness = 0.3, .anisotropy = 0.8, .anisotropy_rotation = 0.5};
    const Scene grain = bent_meshes(instancing, brushed, [&](Scene& scene, std::uint32_t row) {
      std::get<GltfBsdf>(scene.materials[row].bsdf).anisotropy_directions.texture = std::uint32_t{0};
      return row;
    });
    compare("directions of anisotropy" + where, grain, 20000, 1500, 1500);
    const Scene tinted = bent_meshes(instancing, {.roughness = 0.7}, [&](Scene& scene, std::uint32_t row) {
      scene.textures.push_back({.source = BitmapTexture{.bitmap = 0}, .vertex_tint = true, .name = "tinted"});
      scene.textures.push_back(
          {.source = BitmapTexture{.bitmap = 0}, .vertex_tint = true, .alpha_cutoff = 0.4, .name = "cut"});
      std::get<GltfBsdf>(scene.materials[row].bsdf).base_color = ColorParameter(glm::dvec3(0.9), 1);
      row = add_material(scene, TwoSidedAdapter{row, row});
      return add_material(scene, MaskAdapter{{1.0, 2, TextureChannel::alpha}, row});
    });
    compare("tinted" + where, tinted, 20000, 2000, 1500);
  }
}

// Half of the light passes each of them; some lie in the same plane as others, which are listed before or after them,
// and one of these is opaque.
void add_panes(Scene& scene) {
  const auto pane = [&](const Shape& shape, bool opaque) {
    Instance& instance = scene.add(shape, diffuse(0.6));
    instance.material = add_material(scene, TwoSidedAdapter{instance.material, instance.material});
    if (!opaque) instance.material = add_material(scene, MaskAdapter{{0.5}, instance.material});
  };
  const Shape wall = quad({-1.5, 0.1, 1.2}, {2.0, 0, 0.3}, {0, 1.2, 0});
  for (const bool opaque : {false, false, true, false}) pane(wall, opaque);
  pane(quad({0.2, 0.1, 1.9}, {1.0, 0, 0}, {0, 1.2, 0}), false);
  pane(quad({0.2, 0.1, 1.9}, {1.0, 0, 0}, {0, 1.2, 0}), false);
  pane(Sphere{{0.9, 1.3, 1.2}, 0.3}, false);
  pane(Disk{}, false);
  scene.instances.back().world_from_object =
      glm::translate(glm::dmat4(1.0), {0.0, 2.0, 0.4}) * glm::rotate(glm::dmat4(1.0), 1.5, {1.0, 0.2, 0.0});
}

TEST_F(RendererAgreement, SurfacesThatLightPasses) {
  const auto with_panes = [](Scene scene) {
    add_panes(scene);
    return scene;
  };
  Scene few = everything();
  few.instances.erase(few.instances.begin() + 1, few.instances.begin() + 4);
  add_panes(few);
  ASSERT_EQ(compile_scene(few).tree_root, gpu::kNone);
  compare("without a tree", few, 30000, 1500, 1000);
  few.integrator.count_passes = !few.integrator.count_passes;
  few.integrator.max_depth = 4;
  compare("without a tree, passes counted otherwise", few, 30000, 1500, 1000);
  for (const Instancing instancing : {Instancing::never, Instancing::always}) {
    // One of the instances of the mesh is masked, the others are not.
    Scene bent = with_panes(bent_meshes(instancing, {.roughness = 0.7}, [](Scene&, std::uint32_t row) { return row; }));
    const auto shape = bent.instances[bent.instances.size() - 9].shape;
    for (Instance& instance : bent.instances) {
      if (instance.shape != shape) continue;
      instance.material = add_material(bent, MaskAdapter{{0.4}, instance.material});
      break;
    }
    compare(fmt::format("with a tree, instancing {}", static_cast<int>(instancing)), bent, 30000, 2000, 1500);
  }
}

TEST_F(RendererAgreement, LampsOfTwoSidesAndDispersion) {
  for (const Instancing instancing : {Instancing::never, Instancing::always}) {
    for (const auto sampler : {Integrator::LightSampler::power, Integrator::LightSampler::tree}) {
      Scene lamps = bent_meshes(instancing, {}, [](Scene&, std::uint32_t row) { return row; });
      lamps.integrator.light_sampler = sampler;
      lamps.emitters.push_back({.radiance = ColorParameter(glm::dvec3(3.0, 2.0, 1.0), 0), .two_sided = true});
      for (std::size_t i = lamps.instances.size() - 3; i < lamps.instances.size(); ++i)
        lamps.instances[i].emitter = static_cast<std::uint32_t>(lamps.emitters.size() - 1);
      Instance& disk = lamps.add(Disk{}, diffuse(0.5), AreaEmitter{glm::dvec3(4.0), {}, true});
      disk.world_from_object =
          glm::translate(glm::dmat4(1.0), {-0.6, 1.8, 0.5}) * glm::scale(glm::dmat4(1.0), glm::dvec3(0.3));
      compare(fmt::format("two sides {} {}", static_cast<int>(instancing), static_cast<int>(sampler)), lamps, 20000,
              1500, 1500);
    }
  }
  Scene prism = everything();
  const GltfBsdf glass{
      .metallic = 0.0, .roughness = 0.1, .ior = 1.6, .transmission = 1.0, .thin = false, .dispersion = 5.0};
  add(prism, Sphere{{0.3, 0.7, 1.8}, 0.6}, glass);
  compare("dispersion", prism, 40000, 1500, 1500);
  prism.sampler = {Sampler::Type::sobol, 16, 4};
  prism.integrator.type = Integrator::Type::direct;
  compare("dispersion, direct", prism, 20000, 1500, 1500);
}

TEST_F(RendererAgreement, ScaledAndFarFromTheOrigin) {
  compare("1e-3", placed(everything(), 1e-3, {0, 0, 0}), 20000, 1000, 800);
  compare("1e3", placed(everything(), 1e3, {0, 0, 0}), 20000, 1000, 800);
  Scene from_afar = everything();
  for (const double distance : {1e2, 1e4, 1e6}) {
    from_afar.camera.world_from_camera =
        reference::test::look_at({0, 0.3 * distance, distance}, {0, 0.6, 0}, {0, 1, 0});
    from_afar.camera.fov = 180.0 / std::numbers::pi * 6.0 / distance;
    from_afar.camera.far_clip = 1e12;
    compare(fmt::format("from {} away", distance), from_afar, 20000, 1000, 800);
  }
  compare("far away", placed(everything(), 1.0, {3e5, -1e5, 7e5}), 20000, 1000, 800);
}

std::uint32_t fold(const std::vector<PathVertex>& path) {
  std::uint32_t h = 0x811c9dc5u;
  const auto word = [&h](std::uint32_t w) { h = (h ^ w) * 0x01000193u; };
  for (const PathVertex& v : path) {
    if (v.instance == PathVertex::kNone) {
      word(0);
      continue;
    }
    word(v.instance + 1), word(v.primitive + 1);
    if (v.light_instance != PathVertex::kNone)
      word(v.light_instance + 1), word(v.light_primitive + 1), word(v.light_contributed);
    if (v.lobe != PathVertex::kNone) word(v.lobe);
    if (v.survived != PathVertex::kNone) word(v.survived);
  }
  return h;
}

TEST_F(RendererAgreement, PathsAreTracedVertexByVertex) {
  const Scene scene = everything();
  const auto device = make_gpu_renderer(scene, {.seed = 11}, renderer_options());
  const auto reference = make_reference_renderer(scene, {.seed = 11});
  Random random(1);
  constexpr int kPaths = 60;
  std::vector<SampleId> ids;
  ids.reserve(kPaths);
  for (int i = 0; i < kPaths; ++i) ids.push_back({random.below(64 * 48), random.below(1000)});
  const auto device_records = device->trace_samples(ids), reference_records = reference->trace_samples(ids);
  std::size_t agreeing = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto path = device->trace_path(ids[i]);
    ASSERT_FALSE(path.empty());
    EXPECT_EQ(fold(path), device_records[i].signature) << "the two kernels disagree on sample " << i;
    EXPECT_EQ(path.size(), device_records[i].segments);
    EXPECT_NEAR(glm::length(path.back().radiance - device_records[i].radiance), 0.0f, 1e-6f);
    if (device_records[i].signature != reference_records[i].signature) continue;
    ++agreeing;
    const auto expected = reference->trace_path(ids[i]);
    ASSERT_EQ(path.size(), expected.size());
    for (std::size_t k = 0; k < path.size(); ++k) {
      EXPECT_EQ(path[k].instance, expected[k].instance);
      EXPECT_EQ(path[k].primitive, expected[k].primitive);
      EXPECT_EQ(path[k].light_instance, expected[k].light_instance);
      EXPECT_EQ(path[k].light_primitive, expected[k].light_primitive);
      EXPECT_EQ(path[k].light_contributed, expected[k].light_contributed);
      EXPECT_EQ(path[k].lobe, expected[k].lobe);
      EXPECT_EQ(path[k].survived, expected[k].survived);
      const auto near = [](const glm::vec3& a, const glm::vec3& b) {
        return glm::length(a - b) < 1e-3f * (1.0f + glm::length(b));
      };
      EXPECT_TRUE(near(path[k].from, expected[k].from));
      EXPECT_TRUE(near(path[k].to, expected[k].to)) << "where it arrives, or its direction";
      EXPECT_TRUE(k == 0 || near(path[k].from, path[k - 1].to)) << "where the last one arrived";
      EXPECT_LT(glm::length(path[k].radiance - expected[k].radiance),
                1e-3f * (1.0f + glm::length(expected[k].radiance)));
    }
  }
  EXPECT_GE(agreeing, ids.size() - 2);
}

}  // namespace
}  // namespace etendue::test
