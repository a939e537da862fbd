#pragma once
/// Complex indices of refraction of named materials.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/bsdfs.h"

namespace etendue {

/// Rec. 709 values of what scene files name by its chemical symbol ("Au"), by "none" (η = 0, k = 1: reflects
/// everything) or by the names of other optical tables ("Cu_palik"). Empty where the name is unknown.
std::optional<ConductorIndex> metal_index(std::string_view name);
/// All known names, for messages.
std::vector<std::string> metal_names();

}  // namespace etendue
