/// The kernel that casts single rays for the bench, against testing every primitive in double precision.

#include <limits>

#include "bench/ray_check.h"
#include "bench/ray_sets.h"
#include "compile/normalization.h"
#include "device_test.h"
#include "gpu/ray_caster.h"
#include "reference/intersect.h"
#include "reference/ray_caster.h"
#include "reference_scenes.h"
#include "scene/placed.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::box;
using reference::test::diffuse;

class RayCasting : public DeviceTest {
 protected:
  // A soup of triangles and spheres; more than kFewPrimitives when `count` is.
  static Scene soup(std::size_t count, Random& random) {
    Scene scene;
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
      const glm::dvec3 at(random.point(1.0f));
      for (int k = 0; k < 3; ++k) mesh.positions.push_back(at + 0.2 * glm::dvec3(random.point(1.0f)));
      mesh.triangles.push_back(glm::uvec3(0, 1, 2) + 3 * i);
    }
    add(scene, mesh, diffuse(0.5));
    for (int i = 0; i < 3; ++i) add(scene, Sphere{glm::dvec3(random.point(1.0f)), 0.1}, diffuse(0.5));
    return scene;
  }
  static std::vector<CastRay> random_rays(std::size_t count, float t_max, Random& random) {
    std::vector<CastRay> rays;
    for (std::size_t i = 0; i < count; ++i)
      rays.push_back({.o = random.point(0.5f), .t_min = 0.0f, .d = glm::vec3(random.direction()), .t_max = t_max});
    return rays;
  }
};

// Every primitive of the scene, in double precision: the hit nearest to the origin.
CastHit brute_force(const Scene& scene, const Placement& at, const CastRay& cast) {
  const reference::Ray ray{.origin = glm::dvec3(cast.o) / at.scale + at.center,
                           .direction = glm::normalize(glm::dvec3(cast.d)),
                           .t_min = cast.t_min / at.scale,
                           .t_max = cast.t_max / at.scale};
  const reference::TriangleTest test(ray);
  double nearest = ray.t_max;
  CastHit hit{.t = cast.t_max};
  const auto found = [&](double t, std::uint32_t instance, std::uint32_t primitive) {
    nearest = t;
    hit = {.t = static_cast<float>(t * at.scale), .instance = instance, .primitive = primitive};
  };
  for (std::uint32_t k = 0; k < scene.instances.size(); ++k) {
    const Instance& instance = scene.instances[k];
    if (const auto* sphere = std::get_if<Sphere>(&scene.shape_of(instance))) {
      const Sphere s = placed_sphere(*sphere, instance);
      if (const auto t = reference::intersect_sphere(ray, s.center, s.radius, nearest)) found(*t, k, 0);
      continue;
    }
    const PlacedMesh mesh(std::get<TriangleMesh>(scene.shape_of(instance)), instance);
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) {
      const auto [a, b, c] = mesh.triangle(i);
      if (const auto t = test(a, b, c, nearest)) found(t->t, k, i);
    }
  }
  return hit;
}

TEST_F(RayCasting, HitsEqualBruteForce) {
  Random random(11);
  for (const std::size_t triangles : {15, 3000}) {
    const Scene scene = soup(triangles, random);
    const auto caster = make_gpu_ray_caster(scene, renderer_options());
    const std::vector<CastRay> rays = random_rays(4000, std::numeric_limits<float>::infinity(), random);
    caster->load(rays);
    caster->cast(RayQuery::closest);
    const std::vector<CastHit> hits = caster->hits();
    caster->cast(RayQuery::any);
    const std::vector<CastHit> any = caster->hits();
    std::size_t differ = 0, found = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const CastHit expected = brute_force(scene, caster->placement(), rays[i]);
      const bool hit = expected.instance != CastHit::kNone;
      found += hit;
      differ += hits[i].instance != expected.instance || (hit && hits[i].primitive != expected.primitive) ||
                (hit && std::abs(hits[i].t - expected.t) > 1e-4f);
      EXPECT_EQ(any[i].instance != CastHit::kNone, hits[i].instance != CastHit::kNone) << i;
      EXPECT_GT(hits[i].steps, 0u);
    }
    EXPECT_GT(found, triangles > 100 ? 2000u : 100u);
    EXPECT_LE(differ, 2u) << "of 4000 random rays hardly one passes an edge within rounding";
  }
}

TEST_F(RayCasting, RaysEndWhereTheyAreToldTo) {
  Random random(12);
  const Scene scene = soup(1000, random);
  const auto caster = make_gpu_ray_caster(scene, renderer_options());
  const std::vector<CastRay> rays = random_rays(3000, 0.3f, random);
  caster->load(rays);
  for (const RayQuery query : {RayQuery::closest, RayQuery::any}) {
    caster->cast(query);
    std::size_t found = 0, differ = 0;
    for (std::size_t i = 0; const CastHit& hit : caster->hits()) {
      const bool expected = brute_force(scene, caster->placement(), rays[i++]).instance != CastHit::kNone;
      found += expected;
      differ += expected != (hit.instance != CastHit::kNone);
    }
    EXPECT_GT(found, 200u);
    EXPECT_LE(differ, 2u);
  }
}

TEST_F(RayCasting, SetsOfAnySizeOneAfterTheOther) {
  Random random(13);
  const Scene scene = soup(200, random);
  const auto caster = make_gpu_ray_caster(scene, renderer_options());
  const std::vector<CastRay> rays = random_rays(1000, 10.0f, random);
  std::vector<CastHit> all;
  for (const std::size_t count : {1000, 1, 63, 64, 65, 0, 999}) {
    caster->load(std::span(rays).first(count));
    caster->cast(RayQuery::closest);
    const auto hits = caster->hits();
    ASSERT_EQ(hits.size(), count);
    if (all.empty()) all = hits;
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(hits[i].t, all[i].t);
      EXPECT_EQ(hits[i].instance, all[i].instance);
      EXPECT_EQ(hits[i].steps, all[i].steps);
    }
  }
}

// Lamps in one plane: light that goes along it is nobody's, and no ray of the bench may.
TEST_F(RayCasting, TheBenchAcceptsTheDeviceWhereLampsShareAPlane) {
  using reference::test::quad;
  Scene scene;
  for (const double x : {-3.1, -0.03, 2.9, 3.7})
    add(scene, quad({x - 1.1, 0, 0}, {0.3 + 0.2 * x * x, 0, 0}, {0, 1.9, 0}), diffuse(0.0), glm::dvec3(1.0));
  add(scene, quad({-5, 0, 0}, {0, 0, 8}, {10, 0, 0}), diffuse(0.5));
  scene.camera.world_from_camera = reference::test::look_at({0, 1.5, 9}, {0, 0.8, 0}, {0, 1, 0});
  scene.camera.fov = 50.0;
  const auto caster = make_gpu_ray_caster(scene, renderer_options());
  const auto reference = make_reference_ray_caster(scene, caster->placement());
  for (const RaySet& set : make_ray_sets(scene, *caster, {.count = 40000})) {
    caster->load(set.rays);
    caster->cast(set.query);
    const RayCheck check = check_rays(set, caster->hits(), *reference, set.rays.size());
    EXPECT_EQ(check.wrong, 0u) << set.name();
    EXPECT_LE(check.differ, set.rays.size() / 5000) << set.name();
  }
}

TEST_F(RayCasting, TheBenchAcceptsTheDevice) {
  Scene scene;
  const glm::dvec3 at(1000.0, -50.0, 3.0);
  add(scene, box(at - 2.0, at + 2.0, true), diffuse(0.5));
  add(scene, box(at - glm::dvec3(0.1, 0.5, 0.5), at + 0.5, false), diffuse(0.5), glm::dvec3(1.0));
  add(scene, Sphere{at + glm::dvec3(1.0, 0.0, 0.5), 0.6}, diffuse(0.5));
  scene.camera.world_from_camera = reference::test::look_at(at - glm::dvec3(1.5, 0.7, 1.6), at, glm::dvec3(0, 1, 0));
  scene.camera.fov = 70.0;
  const auto caster = make_gpu_ray_caster(scene, renderer_options());
  const auto reference = make_reference_ray_caster(scene, caster->placement());
  const auto sets = make_ray_sets(scene, *caster, {.count = 20000});
  ASSERT_EQ(sets.size(), 6u);
  for (const RaySet& set : sets) {
    caster->load(set.rays);
    caster->cast(set.query);
    const RayCheck check = check_rays(set, caster->hits(), *reference, set.rays.size());
    EXPECT_EQ(check.wrong, 0u) << set.name() << ' ' << check.differ;
    EXPECT_GT(check.hits, 1000u) << set.name();
  }
}

}  // namespace
}  // namespace etendue::test
