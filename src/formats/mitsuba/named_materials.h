#pragma once
/// Indices of refraction that Mitsuba scenes give by name.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

/// The index of "water", "bk7", "air" and others.
std::optional<double> named_ior(std::string_view name);
std::vector<std::string> ior_names();

}  // namespace etendue
