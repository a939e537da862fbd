#include "scene/film_unit.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

#include "image/vectors.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

/// A small sun may be brighter than its sky by more than the film's numbers are long. What pixels show is mostly of the
/// size of the mean; the brightest texel itself must fit, too, with room for the weights of paths.
double largest_of(const Sky& sky) {
  constexpr double kShareOfPeak = 0x1p-12;
  if (!sky.picture) return std::max(largest_component(sky.top), largest_component(sky.horizon));
  const SkyStatistics statistics = sky_statistics(*sky.picture);
  return std::max(statistics.mean, kShareOfPeak * statistics.largest);
}

/// Intensity over irradiance of a projector's plane in the corners of its picture: 1/cos³θ.
double corner_gain(const DeltaLight& light) {
  return std::pow(1.0 + glm::dot(light.slope, light.slope), 1.5);
}

/// Smallest E with value <= 2^E; 0 where the value is not above 0 and finite.
int exponent_above(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 0;
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);  // value = mantissa · 2^exponent, mantissa in [1/2, 1)
  return mantissa == 0.5 ? exponent - 1 : exponent;
}

/// A film takes values up to 2^(E+24). From the farthest point of the scene, at distance R, up to R · 2^-22 from the
/// light, where single precision ends, Φ/(4π²d²) grows by 2^44.
int simple_exponent(const SimpleLight& light, const Bounds& bounds) {
  if (bounds.empty()) return 0;
  const glm::dvec3 farthest = glm::max(glm::abs(bounds.min - light.position), glm::abs(bounds.max - light.position));
  const double least = largest_component(light.energy) / (4.0 * kPi * kPi * glm::dot(farthest, farthest));
  constexpr int kRoom = 20;
  return exponent_above(least) + kRoom;
}

/// 1/t is at most 1 over the near clipping distance, which takes the top of the film's range; the bottom lies 2^80
/// below. Without a near plane the range ends at 2^-40 of the far one.
int depth_exponent(const Camera& camera) {
  const double unit = glm::length(glm::dvec3(camera.world_from_camera[2]));
  const double nearest = std::max(camera.near_clip, camera.far_clip * 0x1p-40) * unit;
  constexpr int kHeadroom = 23;
  return exponent_above(1.0 / nearest) - kHeadroom;
}

/// Distances end about at the far clipping distance; what the film has room for above it holds rays aslant.
int distance_exponent(const Camera& camera) {
  return exponent_above(camera.far_clip * glm::length(glm::dvec3(camera.world_from_camera[2])));
}

/// For lengths and positions: everything that can be hit is within the bounds.
int aov_exponent(const View& view, const Bounds& bounds) {
  if (bounds.empty()) return 0;
  glm::dvec3 largest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
  if (view.integrator.aov == Aov::position) return exponent_above(largest_component(largest));
  if (view.integrator.aov != Aov::depth) return 0;
  const glm::dvec3 camera(view.camera.world_from_camera[3]);
  largest = glm::max(glm::abs(bounds.min - camera), glm::abs(bounds.max - camera));
  return exponent_above(glm::length(largest));
}

}  // namespace

int radiance_exponent(const Scene& scene) {
  double largest = largest_of(scene.sky), intensity = 0.0;
  KnownTextureFacts facts(scene);
  for (const Instance& instance : scene.instances) {
    if (instance.emitter) largest = std::max(largest, EmitterRadiance(facts, instance).largest());
  }
  for (const DeltaLight& light : scene.delta_lights) {
    const double own = largest_component(largest_intensity(scene, light));
    if (light.type == DeltaLight::Type::directional) {
      largest = std::max(largest, own);
    } else {
      intensity += own * (light.type == DeltaLight::Type::projector ? corner_gain(light) : 1.0);
    }
  }
  const double radius = intensity > 0.0 ? typical_radius(scene) : 0.0;
  if (!(radius > 0.0)) return exponent_above(largest);
  constexpr int kRoom = 22;
  const int of_points = exponent_above(intensity / (radius * radius)) + kRoom;
  return largest > 0.0 ? std::max(of_points, exponent_above(largest)) : of_points;
}

double delta_light_limit(int radiance_exponent) {
  constexpr int kBelowTop = 20;
  return std::ldexp(1.0, radiance_exponent + kBelowTop);
}

int view_exponent(const View& view, int radiance_exponent, const Bounds& bounds) {
  if (gathers_light(view.integrator)) return radiance_exponent;
  if (view.integrator.type == Integrator::Type::simple) return simple_exponent(view.integrator.light, bounds);
  if (view.integrator.type == Integrator::Type::depth) return depth_exponent(view.camera);
  if (view.integrator.type == Integrator::Type::distance) return distance_exponent(view.camera);
  if (view.integrator.type == Integrator::Type::aov) return aov_exponent(view, bounds);
  return 0;
}

int film_exponent(const Scene& scene, const View& view) {
  using enum Integrator::Type;
  const bool placed = view.integrator.type == simple || view.integrator.type == aov;
  return view_exponent(view, gathers_light(view.integrator) ? radiance_exponent(scene) : 0,
                       placed ? bounds_of(scene) : Bounds{});
}

int film_exponent(const Scene& scene) {
  return film_exponent(scene, view_of(scene));
}

}  // namespace etendue
