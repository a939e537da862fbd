#pragma once
/// Scenes built in code, and the statistics that compare their renders with known answers.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "reference/frame.h"
#include "reference/reference_renderer.h"
#include "reference/vec.h"

namespace etendue::reference::test {

/// Unit of the films of these tests: samples up to 2^32 are accepted.
inline constexpr int kExponent = 8;

/// |t| that a correct estimator exceeds with probability 1.5e-6 in one test; with about 200 of them the whole file set
/// fails by chance (for new seeds; these are fixed) with probability 3e-4.
inline constexpr double kMaxT = 4.8;

inline TriangleMesh triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {.positions = {a, b, c}, .normals = {}, .triangles = {{0, 1, 2}}};
}
/// Parallelogram with corner `p` and edges `u`, `v`; its normal is u × v.
inline TriangleMesh quad(const Vec3& p, const Vec3& u, const Vec3& v) {
  return {.positions = {p, p + u, p + u + v, p + v}, .normals = {}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
}
/// Axis-aligned box with normals inward or outward.
inline TriangleMesh box(const Vec3& lo, const Vec3& hi, bool inward) {
  TriangleMesh mesh;
  const Vec3 d = hi - lo;
  const auto face = [&](const Vec3& p, const Vec3& u, const Vec3& v) {
    const TriangleMesh q = inward ? quad(p, v, u) : quad(p, u, v);
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec3& corner : q.positions) mesh.positions.push_back(corner);
    for (const glm::uvec3& t : q.triangles) mesh.triangles.push_back(t + base);
  };
  const Vec3 x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
  face(lo, y, x), face(lo, z, y), face(lo, x, z);
  face(hi, -x, -y), face(hi, -y, -z), face(hi, -z, -x);
  return mesh;
}

/// A shape and its looks, with which it can be added to scenes.
struct Body {
  Shape shape;
  Bsdf bsdf;
  std::optional<Vec3> radiance = std::nullopt;
};
inline Instance& add(Scene& scene, Body body) {
  return scene.add(std::move(body.shape), body.bsdf,
                   body.radiance ? std::optional(AreaEmitter{*body.radiance}) : std::nullopt);
}
inline Instance& add(Scene& scene, Shape shape, Bsdf bsdf, std::optional<Vec3> radiance = std::nullopt) {
  return add(scene, Body{std::move(shape), bsdf, radiance});
}
inline DiffuseBsdf diffuse(double albedo) {
  return {.albedo = Vec3(albedo)};
}

inline glm::dmat4 look_at(const Vec3& origin, const Vec3& target, const Vec3& up) {
  const Vec3 forward = glm::normalize(target - origin);
  const Vec3 left = glm::normalize(glm::cross(up, forward));
  return glm::dmat4(glm::dvec4(left, 0), glm::dvec4(glm::cross(forward, left), 0), glm::dvec4(forward, 0),
                    glm::dvec4(origin, 1));
}
inline Camera pixel_camera(const Vec3& origin, const Vec3& target, double fov = 1e-6,
                           const Vec3& up = Vec3(0.0, 0.0, 1.0)) {
  Camera camera;
  camera.width = camera.height = 1;
  camera.fov = fov;
  camera.world_from_camera = look_at(origin, target, up);
  return camera;
}

/// The three ways to find light.
struct Strategy {
  const char* name;
  bool nee, mis;
};
inline constexpr std::array<Strategy, 3> kStrategies{
    {{"naive", false, false}, {"nee", true, false}, {"mis", true, true}}};

inline void set_strategy(Scene& scene, const Strategy& strategy) {
  scene.integrator.nee = strategy.nee;
  scene.integrator.mis = strategy.mis;
}

struct Estimate {
  double mean = 0.0;
  double standard_error = 0.0;
  std::uint64_t n = 0;
  std::uint64_t rejected = 0;
  double t(double reference) const { return std::abs(mean - reference) / standard_error; }
};

/// Mean luminance over the whole film.
inline Estimate estimate(const Scene& scene, std::uint32_t samples, std::uint32_t seed = 1) {
  Film film(scene.camera.width, scene.camera.height, kExponent);
  std::vector<RejectedSample> rejected;
  make_reference_renderer(scene, {.seed = seed, .quantity = FilmQuantity::luminance})
      ->render({0, samples}, film, {}, rejected);
  const Moments m = film_moments(film, 0);
  return {static_cast<double>(m.mean), static_cast<double>(std::sqrt(m.variance / static_cast<long double>(m.n))), m.n,
          film.rejected()};
}

/// Irradiance of a polygon of unit radiance at the origin, normal `n` [Lambert1760]; its winding makes the sign
/// positive when the polygon faces the origin and lies wholly above the horizon.
inline double polygon_irradiance(const std::vector<Vec3>& vertices, const Vec3& n) {
  double sum = 0.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3 a = glm::normalize(vertices[i]);
    const Vec3 b = glm::normalize(vertices[(i + 1) % vertices.size()]);
    const Vec3 edge = glm::cross(a, b);
    const double angle = std::atan2(glm::length(edge), glm::dot(a, b));
    if (angle > 0.0) sum += angle * glm::dot(glm::normalize(edge), n);
  }
  return 0.5 * std::abs(sum);
}
/// Irradiance of a sphere of unit radiance wholly above the horizon: π (r/d)² cos θ.
inline double sphere_irradiance(const Sphere& sphere, const Vec3& n) {
  const double d = glm::length(sphere.center);
  return kPi * sphere.radius * sphere.radius / (d * d) * glm::dot(sphere.center / d, n);
}

/// The floor of the direct-light tests, seen at the origin.
inline Scene floor_scene(double albedo = 0.5) {
  Scene scene;
  scene.camera = pixel_camera({0, 0.01, 0}, {0, 0, 0});
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  add(scene, quad({-10, 0, -10}, {0, 0, 20}, {20, 0, 0}), diffuse(albedo));
  return scene;
}

}  // namespace etendue::reference::test
