#pragma once
/// Common code for generating closed-form scenes: random numbers, shapes, cameras. It shares nothing with the
/// renderers.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "validate/closed_form.h"

namespace etendue::closed_form {

using glm::dvec3;
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kPointFov = 1e-6;  ///< degrees: a camera that looks at one point

inline double luminance(const dvec3& rgb) {
  return glm::dot(rgb, dvec3(0.212671, 0.715160, 0.072169));
}

/// The standard's distributions differ between libraries; these do not.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  double log_between(double low, double high) { return low * std::pow(high / low, unit()); }
  int below(int count) { return static_cast<int>(unit() * count); }
  int between_int(int low, int high) { return low + below(high - low + 1); }
  bool chance(double probability) { return unit() < probability; }
  dvec3 color(double low, double high) { return {between(low, high), between(low, high), between(low, high)}; }
  dvec3 direction() {
    const double z = between(-1.0, 1.0), phi = between(0.0, 2.0 * kPi), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
  /// On the side of `n`, at most acos(`least_cosine`) away from it.
  dvec3 direction_around(const dvec3& n, double least_cosine) {
    dvec3 d = direction();
    while (glm::dot(d, n) < least_cosine) d = direction();
    return d;
  }

 private:
  std::mt19937_64 engine_;
};

/// Two unit vectors that complete `n` to a right-handed basis.
inline std::pair<dvec3, dvec3> tangents(const dvec3& n) {
  const dvec3 s = glm::normalize(glm::cross(std::abs(n.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0), n));
  return {s, glm::cross(n, s)};
}

inline void add_shape(Scene& scene, Shape shape, const Bsdf& bsdf, std::optional<dvec3> radiance = std::nullopt) {
  const char* name = std::holds_alternative<Sphere>(shape) ? "sphere" : "polygon";
  const auto emitter = radiance ? std::optional(AreaEmitter{*radiance}) : std::nullopt;
  scene.add(std::move(shape), bsdf, emitter).name = name;
}

/// Convex polygon as a fan.
inline TriangleMesh polygon_mesh(const std::vector<dvec3>& vertices) {
  TriangleMesh mesh{.positions = vertices, .normals = {}, .triangles = {}};
  for (std::uint32_t i = 2; i < vertices.size(); ++i) mesh.triangles.emplace_back(0, i - 1, i);
  return mesh;
}

inline std::vector<dvec3> corners_of(const TriangleMesh& polygon) {
  return {polygon.positions.begin(), polygon.positions.end()};
}

/// Square of half width `half` around `center` that faces `n`.
inline TriangleMesh square(const dvec3& center, const dvec3& n, double half) {
  const auto [s, t] = tangents(n);
  return polygon_mesh(
      {center + half * (-s - t), center + half * (s - t), center + half * (s + t), center + half * (t - s)});
}

inline Camera look_along(const dvec3& origin, const dvec3& direction, double fov) {
  Camera camera;
  camera.width = camera.height = 1;
  camera.fov = fov;
  const auto [s, t] = tangents(direction);
  camera.world_from_camera =
      glm::dmat4(glm::dvec4(s, 0), glm::dvec4(t, 0), glm::dvec4(direction, 0), glm::dvec4(origin, 1));
  return camera;
}

/// Scales, turns and moves everything, camera and sky included: no picture may depend on it.
inline void move_scene(Scene& scene, Dice& dice, bool turn) {
  const double scale = dice.log_between(1e-2, 1e2);
  const dvec3 shift = scale * dice.color(-3.0, 3.0);
  dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  if (turn) {
    z = dice.direction();
    std::tie(x, y) = tangents(z);
  }
  const glm::dmat3 rotation(x, y, z);
  const glm::dmat4 motion(glm::dvec4(scale * x, 0), glm::dvec4(scale * y, 0), glm::dvec4(scale * z, 0),
                          glm::dvec4(shift, 1));
  for (Instance& instance : scene.instances) instance.world_from_object = motion * instance.world_from_object;
  glm::dmat4& view = scene.camera.world_from_camera;
  for (int column = 0; column < 3; ++column) view[column] = glm::dvec4(rotation * dvec3(view[column]), 0);
  view[3] = glm::dvec4(rotation * (scale * dvec3(view[3])) + shift, 1);
  scene.camera.near_clip *= scale;
  scene.camera.far_clip *= scale;
  if (turn) scene.sky.world_from_sky = rotation * scene.sky.world_from_sky;
  for (DeltaLight& light : scene.delta_lights) {
    light.world_from_light = motion * light.world_from_light;
    if (light.type != DeltaLight::Type::directional) light.intensity.value *= scale * scale;
  }
}

inline void set_strategy(Scene& scene, LightStrategy strategy) {
  scene.integrator.nee = strategy != LightStrategy::naive;
  scene.integrator.mis = strategy == LightStrategy::mis;
}

inline ReconstructionFilter random_filter(Dice& dice) {
  ReconstructionFilter filter;
  filter.type = static_cast<ReconstructionFilter::Type>(dice.below(5));
  filter.radius = dice.between(1.0, 3.0);
  filter.stddev = dice.between(0.3, 0.8);
  filter.stretch = dice.between(0.5, 2.0);
  filter.lobes = 1 + dice.below(4);
  return filter;
}

/// Families defined in files of their own.
ClosedFormScene camera_scene(Dice& dice);
ClosedFormScene integrator_scene(Dice& dice, LightStrategy strategy);
/// Scenes of the family direct, for reuse by other families.
ClosedFormScene direct_light_scene(Dice& dice, LightStrategy strategy);
/// Of the families furnace and coverage, likewise.
ClosedFormScene furnace_scene(Dice& dice, LightStrategy strategy);
ClosedFormScene coverage_scene(Dice& dice);
ClosedFormScene environment_scene(Dice& dice, LightStrategy strategy);
ClosedFormScene texture_scene(Dice& dice, LightStrategy strategy);
ClosedFormScene delta_scene(Dice& dice, LightStrategy strategy);
ClosedFormScene adapter_scene(Dice& dice, LightStrategy strategy);
ClosedFormScene aov_scene(Dice& dice, LightStrategy strategy);

}  // namespace etendue::closed_form
