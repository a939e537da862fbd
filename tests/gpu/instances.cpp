/// A tree of two levels against the same scene laid out flat, and against the reference.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "compile/shared_mesh.h"
#include "device_test.h"
#include "gpu/ray_caster.h"
#include "instanced_scenes.h"
#include "reference/ray_caster.h"
#include "reference/reference_renderer.h"
#include "validate/image_tests.h"
#include "validate/sample_comparison.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::diffuse;
using reference::test::quad;

class Instances : public DeviceTest {
 protected:
  // Rays in world space.
  struct WorldRay {
    glm::dvec3 o, d;
  };
  static std::vector<CastHit> cast(const Scene& scene, const std::vector<WorldRay>& rays, RayQuery query) {
    const auto caster = make_gpu_ray_caster(scene, renderer_options());
    const Placement at = caster->placement();
    std::vector<CastRay> normalised;
    for (const WorldRay& ray : rays)
      normalised.push_back(
          {.o = glm::vec3((ray.o - at.center) * at.scale), .d = glm::vec3(glm::normalize(ray.d)), .t_max = INFINITY});
    caster->load(normalised);
    caster->cast(query);
    std::vector<CastHit> hits = caster->hits();
    for (CastHit& hit : hits) hit.t /= static_cast<float>(at.scale);
    return hits;
  }
  static std::vector<WorldRay> rays_in_box(const glm::dvec3& lower, const glm::dvec3& upper, std::size_t n,
                                           std::uint64_t seed) {
    Random random(seed);
    std::vector<WorldRay> rays;
    for (std::size_t i = 0; i < n; ++i)
      rays.push_back(
          {glm::mix(lower, upper, glm::dvec3(random.unit(), random.unit(), random.unit())), random.direction()});
    return rays;
  }

  void agree(const std::string& what, const Scene& scene, std::uint64_t budget, double flips, double off) {
    const auto device = make_gpu_renderer(scene, {.seed = 11}, renderer_options());
    const auto reference = make_reference_renderer(scene, {.seed = 11});
    const SampleComparison c = compare_samples(*device, *reference, scene.camera.width, scene.camera.height, budget);
    std::string where;
    for (const auto& [difference, count] : c.first_differences) where += fmt::format("\n  {} × {}", count, difference);
    SCOPED_TRACE(fmt::format("{}: {} samples, {:.0f} flips and {:.0f} off per million, median {:.2g}, largest {:.2g}{}",
                             what, c.samples, c.flips_per_million(), c.off_per_million(), c.median_error, c.max_error,
                             where));
    EXPECT_EQ(c.non_finite, 0u);
    EXPECT_LE(c.flips_per_million(), flips);
    EXPECT_LE(c.off_per_million(), off);
    EXPECT_LT(c.median_error, 5e-5);
    RecordProperty(what + "_flips_per_million", std::to_string(c.flips_per_million()));
    RecordProperty(what + "_off_per_million", std::to_string(c.off_per_million()));
  }

  static Image render(const Scene& scene, std::uint32_t seed, std::uint32_t spp) {
    const auto renderer = make_gpu_renderer(scene, {.seed = seed}, renderer_options());
    Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
    std::vector<RejectedSample> rejected;
    renderer->render({0, spp}, film, {}, rejected);
    return image_from_film(film, {});
  }
};

// The same instance and primitive at the same distance, but for rays that pass an edge within rounding.
TEST_F(Instances, HitsAreThoseOfTheFlatScene) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Scene shared = instanced_room(seed, Instancing::always), flat = instanced_room(seed, Instancing::never);
    ASSERT_TRUE(Sharing(shared).any());
    const auto rays = rays_in_box({-3.9, 0.1, -3.9}, {3.9, 4.9, 3.9}, 40000, seed);
    const auto found = cast(shared, rays, RayQuery::closest), expected = cast(flat, rays, RayQuery::closest);
    const auto any = cast(shared, rays, RayQuery::any);
    std::size_t differ = 0, on_instances = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_NE(found[i].instance, CastHit::kNone) << "a ray left the closed room";
      ASSERT_NE(any[i].instance, CastHit::kNone);
      on_instances += expected[i].instance >= 2;
      const bool same = found[i].instance == expected[i].instance && found[i].primitive == expected[i].primitive &&
                        std::abs(found[i].t - expected[i].t) < 2e-5f * (1.0f + expected[i].t);
      differ += !same;
    }
    EXPECT_GT(on_instances, rays.size() / 25);
    EXPECT_LE(differ, 20u) << "of " << rays.size();
  }
}

TEST_F(Instances, PathsAreThoseOfTheReference) {
  for (const std::uint64_t seed : {1, 2}) {
    const Scene scene = instanced_room(seed, Instancing::always);
    agree(fmt::format("tree {}", seed), scene, 30000, 1500, 800);
    Scene power = instanced_room(seed, Instancing::always, 2);
    power.integrator.light_sampler = Integrator::LightSampler::power;
    agree(fmt::format("power {}", seed), power, 30000, 1500, 800);
    Scene naive = scene;
    naive.integrator.nee = false;
    agree(fmt::format("naive {}", seed), naive, 30000, 1500, 800);
  }
}

// Lights of shared meshes are chosen otherwise than those of copies, so pictures differ as two estimates of the same
// do.
TEST_F(Instances, PicturesAreThoseOfTheFlatScene) {
  for (const auto sampler : {Integrator::LightSampler::power, Integrator::LightSampler::tree}) {
    Scene shared = instanced_room(4, Instancing::always), flat = instanced_room(4, Instancing::never);
    shared.integrator.light_sampler = flat.integrator.light_sampler = sampler;
    shared.integrator.max_depth = flat.integrator.max_depth = 3;
    const ImageTests tests = test_images(render(shared, 1, 256), render(flat, 2, 256), 1e-4);
    EXPECT_TRUE(tests.passed()) << tests.families.back().worst_z;
    EXPECT_LT(tests.detectable_bias, 0.05);
  }
}

// Irradiance under a lamp that is an instance: an ellipse, the image of a polygon with many corners under scale, shear
// and a mirror. What arrives at a point of a plane parallel to it is known by Lambert's formula for its polygon.
double irradiance(const std::vector<glm::dvec3>& polygon, const glm::dvec3& at, const glm::dvec3& normal) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 a = glm::normalize(polygon[i] - at), b = glm::normalize(polygon[(i + 1) % polygon.size()] - at);
    const glm::dvec3 c = glm::cross(a, b);
    sum += std::acos(glm::clamp(glm::dot(a, b), -1.0, 1.0)) * glm::normalize(c);
  }
  return 0.5 * std::abs(glm::dot(sum, normal));
}

TEST_F(Instances, EllipticLampsSendWhatTheyShould) {
  TriangleMesh disk{.positions = {{0, 0, 0}}};
  constexpr std::uint32_t kCorners = 48;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double phi = 2.0 * std::numbers::pi * i / kCorners;
    disk.positions.emplace_back(std::cos(phi), 0.0, std::sin(phi));
    disk.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % kCorners);  // faces −y
  }
  for (const bool mirrored : {false, true}) {
    for (const auto sampler : {Integrator::LightSampler::power, Integrator::LightSampler::tree}) {
      for (const bool mis : {false, true}) {
        Scene scene;
        scene.instancing = Instancing::always;
        add(scene, quad({-20, 0, -20}, {0, 0, 40}, {40, 0, 0}), diffuse(0.8));
        scene.shapes.emplace_back(disk);
        scene.materials.push_back({.bsdf = diffuse(0.0)});
        scene.emitters.push_back({.radiance = glm::dvec3(2.0)});
        double expected = 0.0;
        for (int k = 0; k < 2; ++k) {
          glm::dmat4 m(1.0);
          m[0] = {1.7, 0.2, 0.3, 0.0};
          m[1] = {0.1, 0.8, 0.0, 0.0};
          m[2] = {0.6, -0.1, 0.5 + 0.4 * k, 0.0};
          m[3] = {k == 0 ? -2.0 : 1.5, 2.0 + k, 0.4, 1.0};
          if (mirrored) m[0] *= -1.0;
          scene.instances.push_back({.shape = 1, .material = 1, .emitter = 0, .world_from_object = m});
          std::vector<glm::dvec3> outline;
          for (std::uint32_t i = 1; i <= kCorners; ++i) outline.emplace_back(m * glm::dvec4(disk.positions[i], 1.0));
          expected += 2.0 * 0.8 / std::numbers::pi * irradiance(outline, {0.3, 0, 0.1}, {0, 1, 0});
        }
        scene.integrator.max_depth = 2;
        scene.integrator.light_sampler = sampler;
        scene.integrator.mis = mis;
        scene.camera = reference::test::pixel_camera({0.3, 1.0, 0.1}, {0.3, 0, 0.1});
        const Image image = render(scene, 3, 1 << 17);
        const double mean = image.pixels[0].x, error = image.standard_error[0].x;
        EXPECT_LT(error, 0.01 * expected);
        EXPECT_NEAR(mean, expected, 4.8 * error + 1e-5 * expected)
            << (mirrored ? "mirrored " : "") << static_cast<int>(sampler) << ' ' << mis;
      }
    }
  }
}

// Whatever an instance is made of, a closed one lets nobody out.
TEST_F(Instances, ClosedSurfacesDoNotLeak) {
  std::mt19937_64 engine(5);
  for (const double size : {1.0, 1e-3, 1e3}) {
    Scene scene;
    scene.instancing = Instancing::always;
    scene.shapes.emplace_back(bumpy_ball(24));
    scene.materials.push_back({});
    const glm::dmat4 m = random_transform(engine, {3.0, -2.0, 1.0}, size);
    scene.instances.push_back({.world_from_object = m});
    // Something far away, so that the instance is small.
    add(scene, Sphere{{50 * std::max(1.0, size), 0, 0}, 1.0}, diffuse(0.5));
    Random random(6);
    std::vector<WorldRay> rays;
    const auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
    for (int i = 0; i < 60000; ++i) {
      const glm::uvec3 t = mesh.triangles[random.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
      const double along = i % 4 == 0 ? 0.0 : random.unit();
      const glm::dvec3 on_edge = glm::mix(mesh.positions[t.x], mesh.positions[t.y], along);
      const glm::dvec3 o(m * glm::dvec4(glm::dvec3(random.point(0.25f)), 1.0)), to(m * glm::dvec4(on_edge, 1.0));
      rays.push_back({o, to - o});
    }
    for (const RayQuery query : {RayQuery::closest, RayQuery::any}) {
      std::size_t leaks = 0;
      for (const CastHit& hit : cast(scene, rays, query))
        leaks += query == RayQuery::closest ? hit.instance != 0 : hit.instance == CastHit::kNone;
      EXPECT_EQ(leaks, 0u) << "size " << size;
    }
  }
}

// Rays that leave an instance do not meet it again at once: a white furnace inside one keeps its light, however the
// instance is placed.
TEST_F(Instances, RaysLeaveFarTinyAndStretchedInstances) {
  struct Case {
    const char* name;
    glm::dmat4 m;
  };
  glm::dmat4 stretched = glm::rotate(glm::dmat4(1.0), 0.7, glm::normalize(glm::dvec3(1, 2, 3)));
  stretched = glm::rotate(glm::scale(stretched, glm::dvec3(1.0, 0.02, 3.0)), 1.1, glm::normalize(glm::dvec3(3, -1, 2)));
  const Case cases[] = {{"far away", glm::translate(glm::dmat4(1.0), {900.0, -300.0, 500.0})},
                        {"tiny", glm::scale(glm::translate(glm::dmat4(1.0), {-400.0, 2.0, 3.0}), glm::dvec3(2e-3))},
                        {"stretched", stretched}};
  for (const Case& c : cases) {
    Scene scene;
    scene.instancing = Instancing::always;
    // Convex, so that no light returns to it: albedo 0.5 under a sky of 1 is 0.5 everywhere.
    TriangleMesh ball = bumpy_ball(12, false);
    for (glm::dvec3& p : ball.positions.edit()) p = glm::normalize(p);
    scene.shapes.emplace_back(ball);
    scene.materials.push_back({.bsdf = diffuse(0.5)});
    scene.instances.push_back({.world_from_object = c.m});
    add(scene, Sphere{{1e3, 1e3, 1e3}, 1e-3}, diffuse(0.5));
    add(scene, Sphere{{-1e3, -1e3, -1e3}, 1e-3}, diffuse(0.5));
    scene.sky = {.top = glm::dvec3(1.0), .horizon = glm::dvec3(1.0)};
    scene.camera.width = scene.camera.height = 32;
    const glm::dvec3 center(c.m[3]);
    const double size =
        glm::length(glm::dvec3(c.m[0])) + glm::length(glm::dvec3(c.m[1])) + glm::length(glm::dvec3(c.m[2]));
    scene.camera.world_from_camera =
        reference::test::look_at(center + size * glm::dvec3(1.0, 0.7, 1.3), center, {0, 1, 0});
    scene.camera.near_clip = 1e-6 * size;
    scene.camera.far_clip = 1e6;
    scene.camera.fov = 30.0;
    scene.integrator.max_depth = 8;
    scene.integrator.nee = false;  // each sample that leaves the ball is 0.5
    const Image image = render(scene, 1, 64);
    scene.instancing = Instancing::never;
    const Image flat = render(scene, 1, 64);
    std::size_t on_it = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      on_it += flat.pixels[i].x == 0.5f;
      // A pixel at the outline may differ by a sample or two.
      EXPECT_NEAR(image.pixels[i].x, flat.pixels[i].x, flat.pixels[i].x == 0.5f ? 1e-6 : 0.02) << c.name;
    }
    EXPECT_GT(on_it, 50u) << c.name;
  }
}

// Several instances of a mesh at the same place, and one of an equal mesh that is another: their rays are equal, so are
// distances to the bit, and the first of the scene is seen.
TEST_F(Instances, TheFirstOfCoincidentInstancesIsMet) {
  std::mt19937_64 engine(7);
  const glm::dmat4 m = random_transform(engine, {0, 0, 0}, 1.0);
  const auto rays = rays_in_box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 5000, 8);
  for (const std::uint32_t first : {0u, 1u}) {
    Scene scene;
    scene.instancing = Instancing::always;
    scene.shapes.emplace_back(bumpy_ball(8));
    scene.shapes.emplace_back(bumpy_ball(8));
    scene.materials.push_back({});
    add(scene, Sphere{{9, 0, 0}, 1.0}, diffuse(0.5));
    for (const std::uint32_t shape : {first, 1 - first, first})
      scene.instances.push_back({.shape = shape, .world_from_object = m});
    for (const CastHit& hit : cast(scene, rays, RayQuery::closest)) ASSERT_EQ(hit.instance, 1u);
  }
}

// Small scenes are flat, whatever they share; a lamp of many triangles on many instances is one table.
TEST(InstancesCompiled, TablesDoNotGrowWithTheCopies) {
  Scene scene = instanced_room(1, Instancing::automatic);
  EXPECT_FALSE(Sharing(scene).any());
  EXPECT_TRUE(compile_scene(scene).places.empty());
  scene.instances.clear();
  for (std::uint32_t i = 0; i < 5000; ++i) {
    glm::dmat4 m(1.0);
    m[3] = {2.0 * (i % 70), 0.0, 2.0 * (i / 70), 1.0};
    scene.instances.push_back({.shape = 2, .material = 0, .emitter = 0, .world_from_object = m});
  }
  ASSERT_GT(5000 * primitive_count(scene.shapes[2]), kFlattenAtMost);
  const CompiledScene compiled = compile_scene(scene);
  EXPECT_EQ(compiled.places.size(), 5000u);
  EXPECT_LE(compiled.light_primitives.size(), primitive_count(scene.shapes[2]));
  EXPECT_EQ(compiled.light_pairs.size(), 4999u);
  EXPECT_LT(compiled.records.size(), 5000u * 8);
}

}  // namespace
}  // namespace etendue::test
