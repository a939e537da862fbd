#include "formats/nori/plugins.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;

constexpr Range kAnywhere{-kMaxCoordinate, kMaxCoordinate, false, false};
constexpr Range kLight{0.0, kMaxRadiance, false, false};
constexpr Range kAngle{0.0, 180.0, true, false};

Parameter power_parameter() {
  return {"power", color, "", kLight, "power, W; it or intensity is needed"};
}
Parameter place(const char* what) {
  return {"toWorld", transform, "", {}, what};
}

std::vector<Parameter> directions() {
  return {{"direction", vector, "", kAnywhere, "where it shines"},
          {"target", point, "", kAnywhere, "or a point that it shines at"}};
}

Plugin spot_plugin() {
  Plugin row{
      "emitter",
      "spot",
      "A point that shines into a cone; a child of <scene>. It stands at position and shines in a direction or at "
      "a target, or both follow from toWorld, which takes the origin and +z there. Found like point.",
      {{"position", point, "", kAnywhere, "where it stands"}},
      {}};
  for (Parameter& parameter : directions()) row.parameters.push_back(parameter);
  const std::vector<Parameter> rest = {
      {"intensity", color, "", kLight, "power per solid angle along its axis, W/sr; a texture lies across the cone",
       "texture"},
      power_parameter(),
      {"cutoffAngle", real, "20", kAngle, "half angle of the cone, degrees; with a texture at most 89"},
      {"beamWidth",
       real,
       "",
       {0.0, 180.0, false, false},
       "half angle of what shines in full, degrees; three quarters of the cone unless given"},
      {"totalWidth", real, "20", kAngle, "cutoffAngle in the words of other courses"},
      {"falloffStart", real, "", {0.0, 180.0, false, false}, "and beamWidth"},
      {"falloff",
       string,
       "",
       {},
       "how it fades between the two: linear in the angle; smooth, a cubic, or quartic, the fourth power, of the "
       "cosine. linear unless given, with totalWidth or falloffStart quartic"},
      place("its own space to world space: rotations, reflections and translations")};
  row.parameters.insert(row.parameters.end(), rest.begin(), rest.end());
  return row;
}

Plugin directional_plugin(const char* type, const char* doc) {
  Plugin row{"emitter", type, doc, directions(), {}};
  row.parameters.erase(row.parameters.begin() + 1);
  const std::vector<Parameter> rest = {
      {"irradiance", color, "", kLight, "of a surface that faces it, W/m²; it or radiance is needed"},
      {"radiance", color, "", kLight, "another word for irradiance"},
      place("instead of a direction: it shines along +z of this")};
  row.parameters.insert(row.parameters.end(), rest.begin(), rest.end());
  return row;
}

}  // namespace

std::vector<Plugin> delta_light_plugins() {
  return {
      {"emitter",
       "point",
       "A point that shines alike to all sides; a child of <scene>. Light of points is found by sampling lights alone: "
       "integrators that do not are dark.",
       {{"position", point, "", kAnywhere, "where it stands; the origin of toWorld unless given"},
        {"intensity", color, "", kLight, "power per solid angle, W/sr"},
        power_parameter(),
        place("instead of a position")},
       {}},
      spot_plugin(),
      {"emitter",
       "projector",
       "A perspective camera turned around: a picture, sent from the origin of toWorld along +z, its upper edge toward "
       "+y. A child of <scene>. Found like point.",
       {{"irradiance", color, nullptr, kLight,
         "of a plane at distance 1, W/m², or a texture: the picture; textures count from its lower left corner",
         "texture"},
        {"scale", real, "1", {0.0, kMaxRadiance, false, false}, "factor of it"},
        {"fov", real, "30", {0.0, 180.0, true, true}, "angle of the picture's width, degrees"},
        {"aspect", real, "1", {0.0, 1000.0, true, false}, "width of the picture over its height"},
        place("its own space to world space: rotations, reflections and translations")},
       {}},
      directional_plugin("directional",
                         "Light from infinitely far away, all of one direction, like that of the sun. A child of "
                         "<scene>. Found like point."),
      directional_plugin("distant", "Another word for directional."),
  };
}

}  // namespace etendue
