#include "formats/nori/plugins.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;

constexpr Range kAnywhere{-kMaxCoordinate, kMaxCoordinate, false, false};
constexpr Range kLight{0.0, kMaxRadiance, false, false};
constexpr Range kAngle{0.0, 180.0, true, false};

Parameter power_parameter() {
  return {"power", color, "", kLight, "power in W; either power or intensity is required"};
}
Parameter light_scale() {
  return {"scale", real, "1", {0.0, kMaxRadiance, false, false}, "a factor"};
}
Parameter place(const char* what) {
  return {"toWorld", transform, "", {}, what};
}

std::vector<Parameter> directions() {
  return {{"direction", vector, "", kAnywhere, "direction in which the light travels"},
          {"target", point, "", kAnywhere, "a point to aim at, instead of direction"}};
}

Plugin spot_plugin() {
  Plugin row{"emitter",
             "spot",
             "A point that emits into a cone; a child of <scene>. Give position and either direction or target, or "
             "toWorld, which transforms the origin and +z. Reached only by sampling lights, like point.",
             {{"position", point, "", kAnywhere, "position"}},
             {}};
  for (Parameter& parameter : directions()) row.parameters.push_back(parameter);
  const std::vector<Parameter> rest = {
      {"intensity", color, "", kLight,
       "power per solid angle along the axis, W/sr; a texture is projected across the cone", "texture"},
      power_parameter(),
      {"color", color, "", kLight, "as some courses have it: the intensity is color/4π, and the light fades linearly"},
      {"cutoffAngle", real, "20", kAngle, "half angle of the cone in degrees; with a texture at most 89"},
      {"beamWidth",
       real,
       "",
       {0.0, 180.0, false, false},
       "half angle of full intensity in degrees; by default three quarters of cutoffAngle"},
      {"totalWidth", real, "20", kAngle, "another name for cutoffAngle"},
      {"falloffStart", real, "", {0.0, 180.0, false, false}, "another name for beamWidth"},
      {"cosTotalWidth", real, "", {-1.0, 180.0, false, false}, "totalWidth: its cosine, or above 1 in degrees"},
      {"cosFalloffStart", real, "", {-1.0, 180.0, false, false}, "falloffStart, likewise"},
      {"theta",
       real,
       "",
       {0.0, 360.0, true, false},
       "as one course has it: twice cutoffAngle, in degrees; power is then the intensity"},
      {"thetaFalloff", real, "", {0.0, 360.0, false, false}, "twice beamWidth, together with theta"},
      {"thetaMax", real, "", kAngle, "as another course has it: cutoffAngle; power is then the intensity"},
      {"thetaFall", real, "", {0.0, 180.0, false, false}, "beamWidth, together with thetaMax"},
      {"falloff",
       string,
       "",
       {},
       "how the light fades between the two: linear in the angle; or smooth (a cubic) or quartic (the fourth power) in "
       "the cosine. The default is linear, or quartic with totalWidth or falloffStart"},
      light_scale(),
      place("object space to world space: rotations, reflections and translations")};
  row.parameters.insert(row.parameters.end(), rest.begin(), rest.end());
  return row;
}

Plugin directional_plugin(const char* type, const char* doc) {
  Plugin row{"emitter", type, doc, directions(), {}};
  row.parameters.erase(row.parameters.begin() + 1);
  const std::vector<Parameter> rest = {
      {"irradiance", color, "", kLight,
       "irradiance of a surface that faces the light, W/m²; either irradiance or radiance is required"},
      {"radiance", color, "", kLight, "another name for irradiance"},
      light_scale(),
      place("instead of direction: the light travels along its +z")};
  row.parameters.insert(row.parameters.end(), rest.begin(), rest.end());
  return row;
}

Plugin daylight_plugin(const char* type, const char* doc, bool sky, bool sun) {
  Plugin row{"emitter", type, doc, {}, {}};
  row.parameters = {
      {"turbidity", real, "3", {1.9, 10.0, false, false}, "how hazy the air is: 2 is very clear, 6 is hazy"},
      {"sunDirection", vector, "", kAnywhere,
       "toward the sun, above the horizon; the default follows from place and time:"},
      {"latitude",
       real,
       "35.6894",
       {-90.0, 90.0, false, false},
       "degrees north; the defaults are a summer afternoon in Tokyo"},
      {"longitude", real, "139.6917", {-180.0, 180.0, false, false}, "degrees east"},
      {"timezone", real, "9", {-14.0, 14.0, false, false}, "hours ahead of universal time"},
      {"month", integer, "7", {1.0, 12.0, false, false}, "of the year"},
      {"day", integer, "10", {1.0, 31.0, false, false}, "of the month"},
      {"hour", real, "15", {0.0, 24.0, false, false}, "local time, with fractions"}};
  const Range factor{0.0, 1e6, false, false};
  if (sky) row.parameters.push_back({"skyScale", real, "1", factor, "factor of the sky's radiance"});
  if (sun) {
    row.parameters.push_back({"sunScale", real, "1", factor, "factor of the sun's radiance"});
    row.parameters.push_back(
        {"sunRadiusScale",
         real,
         "1",
         {0.0, 60.0, false, false},
         "radius of the sun's disk relative to the real one, 0.2665 degrees; its irradiance does not change"});
  }
  row.parameters.push_back({"groundAlbedo",
                            real,
                            "0",
                            {0.0, 1.0, false, false},
                            "albedo of a matt ground below the horizon, lit by sky and sun"});
  row.parameters.push_back({"resolution",
                            integer,
                            "1024",
                            {16.0, 8192.0, false, false},
                            "width of the sky picture, a power of two; it is half as high"});
  row.parameters.push_back(place("rotates sky and sun; without it +y is up, +x east, -z north"));
  return row;
}

}  // namespace

std::vector<Plugin> daylight_plugins() {
  const char* sky =
      "A clear sky after [Preetham1999], without the sun. A child of <scene>, instead of sky_top and sky_horizon. "
      "Radiance is in W/(m² sr nm), averaged as in Mitsuba, so that 1 is 73 000 cd/m²; the sky is of the order of 0.1.";
  return {daylight_plugin("sky", sky, true, false),
          daylight_plugin("sun",
                          "The sun alone, attenuated by the air. It is a disk in a picture: at a lower resolution it "
                          "becomes larger, with the same power.",
                          false, true),
          daylight_plugin("sunsky", "Sky and sun together.", true, true)};
}

std::vector<Plugin> delta_light_plugins() {
  return {
      {"emitter",
       "point",
       "A point that emits equally in all directions; a child of <scene>. Points are reached only by sampling lights: "
       "integrators that do not sample lights show none of their light.",
       {{"position", point, "", kAnywhere, "position; by default the origin of toWorld"},
        {"intensity", color, "", kLight, "power per solid angle, W/sr"},
        power_parameter(),
        light_scale(),
        place("instead of position")},
       {}},
      spot_plugin(),
      {"emitter",
       "projector",
       "A perspective camera in reverse: projects a picture from the origin of toWorld along +z, its upper edge toward "
       "+y. A child of <scene>. Reached only by sampling lights, like point.",
       {{"irradiance", color, nullptr, kLight,
         "irradiance of a plane at distance 1, W/m²; a texture is the picture, with uv = (0, 0) at its lower left "
         "corner",
         "texture"},
        {"scale", real, "1", {0.0, kMaxRadiance, false, false}, "a factor"},
        {"fov", real, "30", {0.0, 180.0, true, true}, "horizontal field of view in degrees"},
        {"aspect", real, "1", {0.0, 1000.0, true, false}, "width of the picture divided by its height"},
        place("object space to world space: rotations, reflections and translations")},
       {}},
      directional_plugin("directional",
                         "Parallel light from infinitely far away, like that of the sun. A child of <scene>. Reached "
                         "only by sampling lights, like point."),
      directional_plugin("distant", "Another name for directional."),
  };
}

}  // namespace etendue
