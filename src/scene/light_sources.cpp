#include "scene/light_sources.h"

#include <optional>
#include <type_traits>

namespace etendue {
namespace {

/// Calls f(name, is a colour, value, texture) for each number of a row; `value` is a reference.
template <typename Sources, typename F>
void each_light_number(Sources& lights, std::uint32_t row, F&& f) {
  const std::optional<std::uint32_t> none;
  if (row < lights.emitters.size()) {
    auto& radiance = lights.emitters[row].radiance;
    f("radiance", radiance.value, radiance.texture);
  } else if (row < lights.emitters.size() + lights.delta_lights.size()) {
    auto& intensity = lights.delta_lights[row - lights.emitters.size()].intensity;
    f("intensity", intensity.value, intensity.texture);
  } else if (lights.sky.picture) {
    f("scale", lights.sky.picture->scale, none);
  } else {
    f("top", lights.sky.top, none);
    f("horizon", lights.sky.horizon, none);
  }
}

}  // namespace

LightSources light_sources_of(const Scene& scene) {
  return {scene.emitters, scene.delta_lights, scene.sky, scene.position};
}

void set_light_sources(Scene& scene, const LightSources& lights) {
  scene.emitters = lights.emitters;
  scene.delta_lights = lights.delta_lights;
  scene.sky = lights.sky;
}

std::uint32_t count_of(const LightSources& lights) {
  return static_cast<std::uint32_t>(lights.emitters.size() + lights.delta_lights.size() + 1);
}

std::vector<MaterialNumber> numbers_of(const LightSources& lights, std::uint32_t row) {
  std::vector<MaterialNumber> numbers;
  each_light_number(lights, row, [&](const char* name, const auto& value, const auto& texture) {
    constexpr bool kColor = !std::is_arithmetic_v<std::remove_cvref_t<decltype(value)>>;
    numbers.push_back({name, kColor, glm::dvec3(value), texture});
  });
  return numbers;
}

std::string type_name(const LightSources& lights, std::uint32_t row) {
  if (row < lights.emitters.size()) return "area";
  if (row == count_of(lights) - 1) return "environment";
  switch (lights.delta_lights[row - lights.emitters.size()].type) {
    case DeltaLight::Type::point:
      return "point";
    case DeltaLight::Type::spot:
      return "spot";
    case DeltaLight::Type::projector:
      return "projector";
    case DeltaLight::Type::directional:
      break;
  }
  return "directional";
}

bool set_number(LightSources& lights, std::uint32_t row, std::string_view name, const glm::dvec3& value) {
  bool found = false;
  each_light_number(lights, row, [&](const char* own, auto& number, const auto&) {
    if (name != own) return;
    found = true;
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(number)>>)
      number = value.x;
    else
      number = value;
  });
  return found;
}

}  // namespace etendue
