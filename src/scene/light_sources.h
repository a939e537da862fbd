#pragma once
/// What emits in a scene, apart from the shapes that it is on, and its numbers by name: what may be changed while it is
/// rendered.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/material_numbers.h"
#include "scene/scene.h"

namespace etendue {

/// The tables of a scene with the same names. As a list, the emitters come first, then the lights without extent, then
/// the sky.
struct LightSources {
  std::vector<AreaEmitter> emitters;
  std::vector<DeltaLight> delta_lights;
  Sky sky;
  SourcePosition position;  ///< of the scene, for messages about the sky
};

LightSources light_sources_of(const Scene& scene);
void set_light_sources(Scene& scene, const LightSources& lights);

/// Length of the list, and what a row of it has: the numbers (of a sky with a picture its scale), the word that a scene
/// file has for its type ("area", "spot", "environment").
std::uint32_t count_of(const LightSources& lights);
std::vector<MaterialNumber> numbers_of(const LightSources& lights, std::uint32_t row);
std::string type_name(const LightSources& lights, std::uint32_t row);

/// Sets one of them; of a number the first component counts. False where there is none of that name. Whether the value
/// makes sense, check_lights() says.
bool set_number(LightSources& lights, std::uint32_t row, std::string_view name, const glm::dvec3& value);

}  // namespace etendue
