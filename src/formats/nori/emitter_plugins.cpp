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
Parameter light_scale() {
  return {"scale", real, "1", {0.0, kMaxRadiance, false, false}, "factor of it"};
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
      light_scale(),
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
      light_scale(),
      place("instead of a direction: it shines along +z of this")};
  row.parameters.insert(row.parameters.end(), rest.begin(), rest.end());
  return row;
}

Plugin daylight_plugin(const char* type, const char* doc, bool sky, bool sun) {
  Plugin row{"emitter", type, doc, {}, {}};
  row.parameters = {
      {"turbidity", real, "3", {1.9, 10.0, false, false}, "how hazy the air is: 2 very clear, 6 hazy"},
      {"sunDirection", vector, "", kAnywhere, "toward the sun, which stands above the horizon; without it:"},
      {"latitude",
       real,
       "35.6894",
       {-90.0, 90.0, false, false},
       "degrees north; the defaults are a summer's afternoon in Tokyo"},
      {"longitude", real, "139.6917", {-180.0, 180.0, false, false}, "degrees east"},
      {"timezone", real, "9", {-14.0, 14.0, false, false}, "hours that clocks are ahead of universal time"},
      {"month", integer, "7", {1.0, 12.0, false, false}, ""},
      {"day", integer, "10", {1.0, 31.0, false, false}, "of the month"},
      {"hour", real, "15", {0.0, 24.0, false, false}, "of the clock, with fractions"}};
  const Range factor{0.0, 1e6, false, false};
  if (sky) row.parameters.push_back({"skyScale", real, "1", factor, "factor of the sky's radiance"});
  if (sun) {
    row.parameters.push_back({"sunScale", real, "1", factor, "factor of the sun's"});
    row.parameters.push_back({"sunRadiusScale",
                              real,
                              "1",
                              {0.0, 60.0, false, false},
                              "radius of its disk in those of the real sun, 0.2665 degrees; its irradiance stays"});
  }
  row.parameters.push_back({"groundAlbedo",
                            real,
                            "0",
                            {0.0, 1.0, false, false},
                            "of a matt ground below the horizon, lit by what is above it"});
  row.parameters.push_back({"resolution",
                            integer,
                            "1024",
                            {16.0, 8192.0, false, false},
                            "width of the picture that is made, a power of two; it is half as high"});
  row.parameters.push_back(place("turns it all; its own axes are +y up, +x east, -z north"));
  return row;
}

}  // namespace

std::vector<Plugin> daylight_plugins() {
  const char* sky =
      "A clear sky after [Preetham1999], without its sun. A child of <scene>, in place of its sky. Radiance is W/(m² "
      "sr "
      "nm), averaged as in Mitsuba, so that 1 is 73 000 cd/m²; the sky is of the order of 0.1.";
  return {daylight_plugin("sky", sky, true, false),
          daylight_plugin("sun",
                          "The sun of sky alone, as bright as the air lets it be. It is a disk in a picture: with less "
                          "resolution it becomes larger, and sends as much.",
                          false, true),
          daylight_plugin("sunsky", "sky and sun together.", true, true)};
}

std::vector<Plugin> delta_light_plugins() {
  return {
      {"emitter",
       "point",
       "A point that shines alike to all sides; a child of <scene>. Light of points is found by sampling lights alone: "
       "integrators that do not are dark.",
       {{"position", point, "", kAnywhere, "where it stands; the origin of toWorld unless given"},
        {"intensity", color, "", kLight, "power per solid angle, W/sr"},
        power_parameter(),
        light_scale(),
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
