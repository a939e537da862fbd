#pragma once
/// Mitsuba's skies. Its models live on tables of coefficients; Preetham's stands for them, which is said.

#include <optional>
#include <string_view>

#include "formats/mitsuba/mitsuba_object.h"
#include "scene/sky.h"

namespace etendue {

/// sky, sun, sunsky
bool is_mitsuba_daylight(std::string_view type);

/// Adds what is missing to the context's list; nothing where the scene is refused for it.
std::optional<Sky> read_mitsuba_daylight(const MitsubaObject& object, const MitsubaContext& context);

}  // namespace etendue
