#pragma once
/// Indices of refraction that Mitsuba's scenes call by name.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

/// That of "water", "bk7", "air".
std::optional<double> named_ior(std::string_view name);
std::vector<std::string> ior_names();

}  // namespace etendue
