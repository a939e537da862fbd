#pragma once
/// What a caller may ask of any reader.

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace etendue {

/// How bright the lamps of a glTF asset are.
enum class GltfLamps {
  automatic,  ///< as Blender's where Blender wrote the file, else as the standard says
  blender,    ///< one 683rd of what is written: Blender turns watts into lumens by that factor
  watts,      ///< point lamps and spots are written in watts, over the whole sphere; Blender's unit "Raw"
  standard,   ///< one candela or lux is one unit, as one cd/m² of a surface is
};

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
  /// the field of view in degrees; of a glTF asset also the name or the number of one of its cameras; "" for none.
  std::string camera;
  /// The time at which what moves is shown, seconds; nothing: as the file says, cameras with a path at 0.
  std::optional<double> at;
  /// Texture coordinates are shown: meshes keep theirs although no texture needs them.
  bool shows_uv = false;
  // Of glTF assets alone.
  std::string scene;      ///< name or number of the scene that is shown; "" for the one that the asset names
  std::string animation;  ///< name or number of the animation that is played; "" for all
  std::string variant;    ///< name of the material variant; "" for none
  GltfLamps lamps = GltfLamps::automatic;
};

}  // namespace etendue
