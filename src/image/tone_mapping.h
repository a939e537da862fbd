#pragma once
/// Conversion of scene radiance for PNG files: exposure, then an operator. docs/image_files.md has the equations.

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// How radiance is brought into [0,1].
enum class ToneMap {
  none,      ///< clipped at 1
  reinhard,  ///< L/(1+L) of the luminance [Reinhard2002], equation 3
  aces,      ///< a filmic curve of each channel [Narkowicz2015]
};

/// What is done to linear values before they are encoded.
struct Display {
  ToneMap tone_map = ToneMap::none;
  double exposure = 0.0;  ///< stops: values are multiplied by 2^exposure first

  bool changes_values() const { return tone_map != ToneMap::none || exposure != 0.0; }
};

/// The names, in the order of ToneMap.
const std::vector<std::string>& tone_map_names();
std::string name_of(ToneMap tone_map);
/// The operator of that name; `name` must be one of tone_map_names().
ToneMap tone_map_of(const std::string& name);

/// Linear Rec. 709 in and out; the result may lie outside [0,1], and NaN stays NaN. In double.
glm::dvec3 tone_mapped(const glm::vec3& linear, const Display& display);

}  // namespace etendue
