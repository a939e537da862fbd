#pragma once
/// Reads Mitsuba's skies. Its models need large tables of coefficients, so Preetham's model replaces them, which is
/// reported.

#include <optional>
#include <string_view>

#include "formats/mitsuba/mitsuba_object.h"
#include "scene/sky.h"

namespace etendue {

/// True for sky, sun and sunsky.
bool is_mitsuba_daylight(std::string_view type);

/// Adds the missing models to the context's list. Returns nothing if the scene is refused because of them.
std::optional<Sky> read_mitsuba_daylight(const MitsubaObject& object, const MitsubaContext& context);

}  // namespace etendue
