/// Rays against primitives and the hierarchy; scale and place of the scene.

#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "reference/intersect.h"
#include "reference/world.h"
#include "reference_scenes.h"
#include "scene/placed.h"

namespace etendue::reference::test {
namespace {

Vec3 random_point(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  const double x = u(random), y = u(random), z = u(random);
  return {x, y, z};
}

/// Triangles of all sizes, among them slivers, points, doubled vertices and lines, and some spheres.
Scene random_soup(std::mt19937_64& random, int triangles, int spheres) {
  Scene scene;
  scene.camera.width = scene.camera.height = 1;
  std::uniform_real_distribution<double> u(0.0, 1.0);
  TriangleMesh mesh;
  for (int i = 0; i < triangles; ++i) {
    const Vec3 p = random_point(random, 1.0);
    const double size = std::pow(10.0, -3.0 * u(random));
    std::array<Vec3, 3> v{p, p + random_point(random, size), p + random_point(random, size)};
    if (i % 10 == 0) v[2] = v[1];
    if (i % 10 == 1) v[2] = v[1] = v[0];
    if (i % 10 == 2) v[2] = 0.5 * (v[0] + v[1]);
    if (i % 10 == 3) v[0].y = v[1].y = v[2].y = std::round(4 * v[0].y) / 4;  // flat boxes, coplanar neighbours
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3& corner : v) mesh.positions.push_back(corner);
    mesh.triangles.push_back({base, base + 1, base + 2});
  }
  add(scene, mesh, diffuse(0.5));
  for (int i = 0; i < spheres; ++i) {
    const Vec3 center = random_point(random, 1.0);
    add(scene, Sphere{center, 0.2 * u(random)}, diffuse(0.5));
  }
  return scene;
}

/// Distance to the nearest primitive, tried one by one; infinity when there is none.
double brute_force(const Scene& scene, const Ray& ray) {
  double t = ray.t_max;
  const TriangleTest test(ray);
  for (const Instance& instance : scene.instances) {
    if (const auto* sphere = std::get_if<Sphere>(&scene.shape_of(instance))) {
      const Sphere s = placed_sphere(*sphere, instance);
      t = intersect_sphere(ray, s.center, s.radius, t).value_or(t);
      continue;
    }
    const PlacedMesh mesh(std::get<TriangleMesh>(scene.shape_of(instance)), instance);
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
      const auto [a, b, c] = mesh.triangle(i);
      if (is_degenerate(a, b, c)) continue;
      if (const auto hit = test(a, b, c, t)) t = hit->t;
    }
  }
  return t;
}

TEST(ReferenceBvh, EqualsBruteForce) {
  std::mt19937_64 random(11);
  for (const int triangles : {0, 1, 3, 40, 2000}) {
    const Scene scene = random_soup(random, triangles, triangles / 20 + 1);
    const World world(scene);
    int hits = 0;
    for (int i = 0; i < 3000; ++i) {
      Vec3 direction = random_point(random, 1.0);
      if (i % 5 == 0) direction[i % 3] = 0.0;                         // in the plane of box faces
      if (i % 7 == 0) direction = Vec3(0.0), direction[i % 3] = 1.0;  // along an axis
      Vec3 origin = random_point(random, 2.0);
      if (i % 4 == 0) origin.y = std::round(4 * origin.y) / 4;
      const Ray ray{.origin = origin, .direction = glm::normalize(direction)};
      const double expected = brute_force(scene, ray);
      const auto hit = world.closest_hit(ray);
      ASSERT_EQ(hit.has_value(), std::isfinite(expected)) << "ray " << i;
      if (!hit) continue;
      ++hits;
      EXPECT_NEAR(glm::dot(hit->p - ray.origin, ray.direction), expected, 1e-9) << "ray " << i;
      // Shadow rays, among them such that end just before and just behind the surface.
      for (const double share : {0.5, 1.0 - 1e-9, 1.0 + 1e-9, 1.5}) {
        const Vec3 to = ray.origin + share * expected * ray.direction;
        const double length = glm::length(to - ray.origin);
        const Ray shadow{.origin = ray.origin, .direction = (to - ray.origin) / length, .t_min = 0, .t_max = length};
        EXPECT_EQ(world.occluded(ray.origin, to), brute_force(scene, shadow) < length) << "ray " << i << ' ' << share;
      }
    }
    EXPECT_GE(hits, triangles / 10);
  }
}

TEST(ReferenceBvh, CoincidentPrimitivesEndInLeaves) {
  Scene scene;
  TriangleMesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  mesh.triangles.assign(10000, {0, 1, 2});
  add(scene, mesh, diffuse(0.5));
  const World world(scene);
  EXPECT_TRUE(world.closest_hit({.origin = {0.2, 0.2, 1}, .direction = {0, 0, -1}}));
  EXPECT_FALSE(world.closest_hit({.origin = {0.9, 0.9, 1}, .direction = {0, 0, -1}}));
}

TEST(ReferenceIntersect, DegenerateTrianglesAreNeverHit) {
  EXPECT_TRUE(is_degenerate({0, 0, 0}, {0, 0, 0}, {0, 0, 0}));
  EXPECT_TRUE(is_degenerate({0, 0, 0}, {1, 1, 1}, {1, 1, 1}));
  EXPECT_TRUE(is_degenerate({0.1, 0.2, 0.3}, {0.4, 0.8, 1.2}, {0.2, 0.4, 0.6}));
  EXPECT_TRUE(is_degenerate({0, 0, 0}, {1, 0, 0}, {std::nan(""), 1, 0}));
  EXPECT_FALSE(is_degenerate({0, 0, 0}, {1e-6, 0, 0}, {0, 1e-6, 0}));
  EXPECT_FALSE(is_degenerate({0, 0, 0}, {1e5, 0, 0}, {0, 1e-3, 0}));
  Scene scene;
  add(scene, triangle({0, 0, 0}, {2, 0, 0}, {1, 0, 0}), diffuse(0.5), Vec3(1.0));
  const World world(scene);
  EXPECT_TRUE(world.lights().empty());
  EXPECT_FALSE(world.closest_hit({.origin = {1, 0, 1}, .direction = {0, 0, -1}}));
}

TEST(ReferenceIntersect, ClosedMeshesLeakNothingAtEdgesAndVertices) {
  // A bumpy closed surface around the origin, subdivided from a box, and rays at its very vertices and edges.
  std::mt19937_64 random(3);
  TriangleMesh mesh;
  constexpr int n = 12;
  const TriangleMesh cube = box(Vec3(-1.0), Vec3(1.0), true);
  const auto vertex = [&](const Vec3& p) {
    const Vec3 w = glm::normalize(p);
    return w * (1.0 + 0.3 * std::sin(5 * w.x + 1) * std::cos(7 * w.y + 2 * w.z)) + Vec3(0.01, 0.02, 0.03);
  };
  for (std::size_t face = 0; face < 6; ++face) {
    const Vec3 p = cube.positions[4 * face], u = cube.positions[4 * face + 1] - p, v = cube.positions[4 * face + 3] - p;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const auto at = [&](int a, int b) {
          // Rounded, so that faces that meet share their vertices to the last bit.
          const Vec3 q = p + u * (static_cast<double>(a) / n) + v * (static_cast<double>(b) / n);
          return vertex(glm::round(q * static_cast<double>(n)) / static_cast<double>(n));
        };
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Vec3& q : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}) mesh.positions.push_back(q);
        mesh.triangles.push_back({base, base + 1, base + 2});
        mesh.triangles.push_back({base, base + 2, base + 3});
      }
    }
  }
  Scene scene;
  add(scene, mesh, diffuse(0.5));
  const World world(scene);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  int leaks = 0;
  for (int i = 0; i < 300000; ++i) {
    const glm::uvec3 t = mesh.triangles[random() % mesh.triangles.size()];
    const Vec3 a = mesh.positions[t.x], b = mesh.positions[t.y];
    const Vec3 target = i % 3 == 0 ? a : glm::mix(a, b, u(random));
    const Vec3 origin = random_point(random, 0.1);
    leaks += world.closest_hit({.origin = origin, .direction = glm::normalize(target - origin)}) ? 0 : 1;
  }
  EXPECT_EQ(leaks, 0);
}

TEST(ReferenceIntersect, SmallFarSpheresKeepTheirDigits) {
  // Radius 1e-3 at distance 1e5: b² − c would have no digit left.
  const Vec3 center = 1e5 * glm::normalize(Vec3(1, 2, -3));
  const Frame frame(glm::normalize(center));
  for (const double offset : {0.0, 0.5, 0.9, 0.999}) {
    const Vec3 through = center + frame.to_world({1e-3 * offset, 0, 0});
    const Ray ray{.origin = Vec3(0.0), .direction = glm::normalize(through)};
    const auto t = intersect_sphere(ray, center, 1e-3, ray.t_max);
    ASSERT_TRUE(t) << offset;
    EXPECT_NEAR(glm::length(*t * ray.direction - center), 1e-3, 1e-9);
    EXPECT_LT(*t, 1e5);
  }
  const Vec3 past = center + frame.to_world({1.001e-3, 0, 0});
  EXPECT_FALSE(intersect_sphere({.origin = Vec3(0.0), .direction = glm::normalize(past)}, center, 1e-3, 1e9));
}

TEST(ReferenceIntersect, SphereFromInsideFromBehindAndWithinLimits) {
  const Vec3 c(0, 0, 5);
  EXPECT_NEAR(*intersect_sphere({.origin = {0, 0, 0}, .direction = {0, 0, 1}}, c, 1, 1e9), 4.0, 1e-15);
  EXPECT_NEAR(*intersect_sphere({.origin = c, .direction = {0, 0, 1}}, c, 1, 1e9), 1.0, 1e-15);
  EXPECT_NEAR(*intersect_sphere({.origin = {0, 0, 0}, .direction = {0, 0, 1}, .t_min = 4.5}, c, 1, 1e9), 6.0, 1e-15);
  EXPECT_FALSE(intersect_sphere({.origin = {0, 0, 0}, .direction = {0, 0, -1}}, c, 1, 1e9));
  EXPECT_FALSE(intersect_sphere({.origin = {0, 0, 0}, .direction = {0, 0, 1}}, c, 1, 3.9));
}

/// A box with a lamp, a diffuse and a glass sphere, some corners and coplanar triangles; `place` maps it into its
/// world.
Scene small_room(double scale, const Vec3& shift) {
  Scene scene;
  const auto at = [&](const Vec3& p) { return scale * (p + shift); };
  const auto mesh = [&](TriangleMesh m) {
    for (Vec3& p : m.positions.edit()) p = at(p);
    return m;
  };
  scene.camera.width = scene.camera.height = 16;
  scene.camera.fov = 70;
  scene.camera.near_clip = 1e-6 * scale;
  scene.camera.far_clip = 100 * scale;
  scene.camera.world_from_camera = look_at(at({0.1, 0.2, -0.9}), at({0, -0.1, 0}), {0, 1, 0});
  scene.integrator.max_depth = 8;
  scene.integrator.rr_depth = 0;
  add(scene, mesh(box(Vec3(-1.0), Vec3(1.0), true)), diffuse(0.6));
  add(scene, mesh(quad({-0.3, 0.98, -0.3}, {0.6, 0, 0}, {0, 0, 0.6})), diffuse(0.5), Vec3(5.0));
  add(scene, Sphere{at({-0.5, -0.6, 0.2}), 0.35 * scale}, diffuse(0.7));
  add(scene, Sphere{at({0.5, -0.5, 0.1}), 0.3 * scale}, DielectricBsdf{});
  add(scene, Sphere{at({0.3, 0.5, 0.6}), 0.1 * scale}, diffuse(0.2), Vec3(8.0));
  return scene;
}

TEST(ReferenceScale, ScenesAlikeAtAnyScaleAndPlace) {
  std::vector<SampleId> ids;
  for (std::uint32_t p = 0; p < 256; ++p)
    for (std::uint32_t s = 0; s < 40; ++s) ids.push_back({p, s});
  const auto expected = make_reference_renderer(small_room(1.0, Vec3(0.0)), {})->trace_samples(ids);
  const std::vector<std::pair<double, Vec3>> places{
      {1e-3, Vec3(0.0)},         {1e3, Vec3(0.0)},          {1e4, Vec3(0.0)}, {1.0, Vec3(1e4, -3e3, 7e3)},
      {1e-3, Vec3(100, 200, 0)}, {1e3, Vec3(-50, 20, 400)}, {1e-6, Vec3(1.0)}};
  for (const auto& [scale, shift] : places) {
    const auto records = make_reference_renderer(small_room(scale, shift), {})->trace_samples(ids);
    int flips = 0;
    double worst = 0.0;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (records[i].signature != expected[i].signature) {
        ++flips;
        continue;
      }
      const double difference = glm::length(records[i].radiance - expected[i].radiance);
      worst = std::max(worst, difference / (1e-3 + glm::length(expected[i].radiance)));
    }
    EXPECT_LE(flips, 3) << "of " << ids.size() << ", scale " << scale << " shift " << shift.x;
    // Far from the origin the geometry itself is rounded (1e-12 of the room's size) and glass magnifies that.
    EXPECT_LT(worst, 1e-4) << "scale " << scale << " shift " << shift.x;
  }
}

TEST(ReferenceScale, NoPathLeavesAClosedRoom) {
  // Every path of a closed diffuse room that reflects everything has full length: a single leak or self-hit that
  // went through a wall would end it in the empty sky, which shines here.
  for (const double scale : {1e-3, 1.0, 1e4}) {
    for (const double shift : {0.0, 1000.0}) {
      Scene scene = small_room(scale, Vec3(shift));
      for (Instance& i : scene.instances) i.emitter.reset();
      scene.sky.top = scene.sky.horizon = Vec3(1.0);
      scene.integrator.max_depth = 20;
      const Estimate e = estimate(scene, 100);
      EXPECT_EQ(e.mean, 0.0) << scale << ' ' << shift;
    }
  }
}

TEST(ReferenceScale, DirectLightIsTheSameAtAnyScale) {
  for (const double scale : {1e-3, 1e3}) {
    Scene scene = floor_scene();
    add(scene,
        triangle({-0.17487, 0.447916, 0.367201}, {-0.405259, 0.249607, -0.354079}, {0.356029, 0.0918984, -0.132271}),
        diffuse(0.0), Vec3(1.0));
    scene.camera.world_from_camera[3] = glm::dvec4(0, 0.01 * scale, 0, 1);
    scene.camera.near_clip = 0.0;
    for (Instance& i : scene.instances) i.world_from_object = glm::scale(glm::dmat4(1.0), Vec3(scale));
    const Estimate e = estimate(scene, 200000);
    EXPECT_LT(e.t(0.26174), kMaxT) << scale << ": " << e.mean;
  }
}

// A ray that meets one copy meets them all; with each of them tested this would take a minute.
TEST(World, CopiesOfAPrimitiveCostNothing) {
  Scene scene;
  scene.camera.width = scene.camera.height = 1;
  TriangleMesh copies{.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}};
  for (int i = 0; i < 300000; ++i) copies.triangles.push_back({0, 1, 2});
  add(scene, copies, diffuse(0.5));
  for (int i = 0; i < 3000; ++i) add(scene, Sphere{{0, 0, 3}, 1.0}, diffuse(0.5));
  const World world(scene);
  std::mt19937_64 random(5);
  const std::clock_t start = std::clock();
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = 0.3 * random_point(random, 1.0);
    const auto triangle = world.closest_hit({.origin = {p.x, p.y, 1.0}, .direction = {0, 0, -1}});
    ASSERT_TRUE(triangle.has_value());
    EXPECT_EQ(triangle->instance, 0u);
    EXPECT_EQ(triangle->primitive, 0u);
    const auto sphere = world.closest_hit({.origin = {p.x, p.y, 9.0}, .direction = {0, 0, -1}});
    ASSERT_TRUE(sphere.has_value());
    EXPECT_EQ(sphere->instance, 1u);
  }
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 5.0) << "seconds of CPU time";
}

}  // namespace
}  // namespace etendue::reference::test
