#include "compile/delta_lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "image/vectors.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

double cos_degrees(double angle) {
  return std::cos(angle * kPi / 180.0);
}

gpu::uint header_of(const DeltaLight& light) {
  const gpu::uint picture = light.intensity.texture ? gpu::kDeltaTextured : 0u;
  switch (light.type) {
    case DeltaLight::Type::point:
      return gpu::kDeltaPoint | picture;
    case DeltaLight::Type::projector:
      return gpu::kDeltaProjector | picture;
    case DeltaLight::Type::directional:
      return gpu::kDeltaDirectional;
    case DeltaLight::Type::spot:
      break;
  }
  const gpu::uint fades = light.falloff == DeltaLight::Falloff::smooth    ? gpu::kDeltaSmooth
                          : light.falloff == DeltaLight::Falloff::quartic ? gpu::kDeltaQuartic
                                                                          : 0u;
  return gpu::kDeltaSpot | picture | fades;
}

void flatten_spot(const DeltaLight& light, gpu::DeltaLight& flat) {
  const double outer = cos_degrees(light.cutoff), inner = cos_degrees(light.beam_width);
  const bool linear = light.falloff == DeltaLight::Falloff::linear;
  const double between = linear ? (light.cutoff - light.beam_width) / 360.0 : inner - outer;
  flat.cos_cutoff = static_cast<float>(outer);
  flat.cos_beam = static_cast<float>(inner);
  flat.cutoff_turns = static_cast<float>(light.cutoff / 360.0);
  flat.fade = between > 0.0 ? static_cast<float>(1.0 / between) : 0.0f;
}

/// Half of the picture for a slope of 1, along `across` and along the cross product of forward and across, which points
/// down if the frame is mirrored.
glm::vec2 picture_scale(const DeltaLight& light) {
  const double up = glm::determinant(glm::dmat3(light.world_from_light)) < 0.0 ? -1.0 : 1.0;
  if (light.type == DeltaLight::Type::projector) return glm::vec2(-0.5 / light.slope.x, 0.5 * up / light.slope.y);
  const double edge = std::tan(light.cutoff * kPi / 180.0);
  return glm::vec2(0.5 / edge, -0.5 * up / edge);
}

}  // namespace

gpu::DeltaLight flatten_delta_light(const Scene& scene, std::uint32_t number, const Normalization& normalization) {
  const DeltaLight& light = scene.delta_lights[number];
  gpu::DeltaLight flat{};
  flat.number = number;
  flat.header = header_of(light);
  flat.texture_index = light.intensity.texture.value_or(gpu::kNone);
  const bool directional = light.type == DeltaLight::Type::directional;
  const double unit = directional ? 1.0 : normalization.scale * normalization.scale;
  flat.intensity = glm::vec3(light.intensity.value * unit);
  flat.p = directional ? glm::vec3(-light.axis(2)) : normalization.point(light.origin());
  flat.forward = glm::vec3(light.axis(2));
  flat.across = glm::vec3(light.axis(0));
  if (light.type == DeltaLight::Type::spot) flatten_spot(light, flat);
  if (light.type == DeltaLight::Type::projector || (light.type == DeltaLight::Type::spot && light.intensity.texture))
    flat.picture_scale = picture_scale(light);
  return flat;
}

double delta_light_power(const Scene& scene, const DeltaLight& light) {
  const double mean = luminance(mean_intensity(scene, light));
  switch (light.type) {
    case DeltaLight::Type::point:
    case DeltaLight::Type::spot:
      return 4.0 * mean;
    case DeltaLight::Type::projector:
      return 4.0 * mean * light.slope.x * light.slope.y / kPi;
    case DeltaLight::Type::directional:
      break;
  }
  return mean;
}

LightLeaf delta_light_leaf(const Scene& scene, const DeltaLight& light) {
  LightLeaf leaf;
  leaf.power = luminance(mean_intensity(scene, light));
  leaf.lower = leaf.upper = light.origin();
  if (light.type == DeltaLight::Type::point) return leaf;
  leaf.normal = light.axis(2);
  leaf.cos_cone = light.type == DeltaLight::Type::spot ? cos_degrees(light.cutoff)
                                                       : 1.0 / std::sqrt(1.0 + glm::dot(light.slope, light.slope));
  return leaf;
}

std::vector<std::uint32_t> delta_light_order(const Scene& scene) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < scene.delta_lights.size(); ++i) {
    if (delta_light_power(scene, scene.delta_lights[i]) > 0.0) order.push_back(i);
  }
  std::ranges::stable_partition(
      order, [&](std::uint32_t i) { return scene.delta_lights[i].type == DeltaLight::Type::directional; });
  return order;
}

}  // namespace etendue
