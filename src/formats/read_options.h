#pragma once
/// What a caller may ask of any reader.

#include <string>
#include <utility>
#include <vector>

namespace etendue {

struct ReadOptions {
  /// "tag.property" and value, as given with -D: {"integrator.nee", "false"}. In a file of several scenes they apply to
  /// each.
  std::vector<std::pair<std::string, std::string>> overrides;
  /// Unknown properties are errors instead of warnings.
  bool strict = false;
};

}  // namespace etendue
