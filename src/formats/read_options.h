#pragma once
/// What a caller may ask of any reader.

#include <string>
#include <utility>
#include <vector>

namespace etendue {

struct ReadOptions {
  /// "tag.property" and value, as given with -D: {"integrator.nee", "false"}. In a file of several scenes they apply to
  /// each. In a scene for Mitsuba, the name of a parameter and its value: {"spp", "64"} for $spp.
  std::vector<std::pair<std::string, std::string>> overrides;
  /// Unknown properties are errors instead of warnings.
  bool strict = false;
  /// What a foreign scene asks for and there is not here is replaced, with a warning for each, instead of refused.
  bool approximate = false;
  /// A picture of latitude and longitude that lights the scene in place of its sky; "" for none.
  std::string environment;
  /// Where the scene is seen from in place of its camera: "x,y,z,x,y,z" of the eye and what it looks at, and perhaps
  /// the field of view in degrees; "" for none.
  std::string camera;
};

}  // namespace etendue
