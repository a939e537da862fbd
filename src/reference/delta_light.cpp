#include "reference/delta_light.h"

#include <algorithm>
#include <cmath>

#include "reference/sampling.h"
#include "reference/texture.h"
#include "scene/texture_facts.h"

namespace etendue::reference {
namespace {

double radians(double degrees) {
  return degrees * kPi / 180.0;
}

/// Fraction of a spot's intensity at the angle `theta` from its axis.
double fading(const DeltaLight& spot, double theta) {
  const double edge = radians(spot.cutoff), beam = radians(spot.beam_width);
  if (theta >= edge) return 0.0;
  if (theta <= beam) return 1.0;
  if (spot.falloff == DeltaLight::Falloff::linear) return (edge - theta) / (edge - beam);
  const double x = (std::cos(theta) - std::cos(edge)) / (std::cos(beam) - std::cos(edge));
  return spot.falloff == DeltaLight::Falloff::smooth ? x * x * (3.0 - 2.0 * x) : std::pow(x, 4.0);
}

Vec3 picture(const Scene& scene, const DeltaLight& light, const Vec2& uv) {
  if (!light.intensity.texture) return Vec3(1.0);
  return Vec3(texture_value(scene, scene.textures[*light.intensity.texture], uv));
}

}  // namespace

Vec3 intensity(const Scene& scene, const DeltaLight& light, const Vec3& w) {
  const Vec3 local(glm::dot(light.axis(0), w), glm::dot(light.axis(1), w), glm::dot(light.axis(2), w));
  const Vec2 slope = Vec2(local) / local.z;
  switch (light.type) {
    case DeltaLight::Type::point:
      return light.intensity.value;
    case DeltaLight::Type::spot: {
      const double share = fading(light, std::atan2(std::hypot(local.x, local.y), local.z));
      if (share == 0.0) return Vec3(0.0);
      const double edge = std::tan(radians(light.cutoff));
      const Vec2 uv(0.5 + 0.5 * slope.x / edge, 0.5 - 0.5 * slope.y / edge);
      return share * light.intensity.value * picture(scene, light, uv);
    }
    case DeltaLight::Type::projector: {
      if (!(local.z > 0.0)) return Vec3(0.0);
      const Vec2 uv(0.5 - 0.5 * slope.x / light.slope.x, 0.5 + 0.5 * slope.y / light.slope.y);
      if (std::min(uv.x, uv.y) < 0.0 || std::max(uv.x, uv.y) > 1.0) return Vec3(0.0);
      return light.intensity.value * picture(scene, light, uv) / std::pow(local.z, 3.0);
    }
    case DeltaLight::Type::directional:
      break;
  }
  return Vec3(0.0);
}

double choice_power(const Scene& scene, const DeltaLight& light) {
  const double mean = luminance(mean_intensity(scene, light));
  switch (light.type) {
    case DeltaLight::Type::point:  // 4π I over π
    case DeltaLight::Type::spot:   // as bright as a point inside its cone
      return 4.0 * mean;
    case DeltaLight::Type::projector:  // irradiance of the plane times the area of the picture there
      return mean * (2.0 * light.slope.x) * (2.0 * light.slope.y) / kPi;
    case DeltaLight::Type::directional:
      break;
  }
  return mean;
}

double cone_cosine(const DeltaLight& light) {
  if (light.type == DeltaLight::Type::spot) return std::cos(radians(light.cutoff));
  return 1.0 / std::hypot(1.0, light.slope.x, light.slope.y);
}

}  // namespace etendue::reference
