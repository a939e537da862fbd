#include "formats/mitsuba/mitsuba_lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

/// Sets the axes to a frame whose +Z is along `z`, which must not be 0.
void point_along(const glm::dvec3& z, glm::dmat4& world_from_light) {
  const glm::dvec3 forward = glm::normalize(z);
  const glm::dvec3 helper = std::abs(forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 across = glm::normalize(glm::cross(helper, forward));
  world_from_light[0] = glm::dvec4(across, 0.0);
  world_from_light[1] = glm::dvec4(glm::cross(forward, across), 0.0);
  world_from_light[2] = glm::dvec4(forward, 0.0);
}

void read_place(const MitsubaObject& object, const char* property, const MitsubaContext& context) {
  if (object.given(property) && object.given("to_world"))
    context.sink.error(
        object.position_of(property),
        fmt::format("the {} has both \"{}\" and \"to_world\"; keep one of them", object.type(), property));
}

void read_direction(const MitsubaObject& object, DeltaLight& light, const MitsubaContext& context) {
  read_place(object, "direction", context);
  if (!object.given("direction")) return;
  const glm::dvec3 direction = object.triple("direction");
  if (glm::length(direction) > 0.0) return point_along(direction, light.world_from_light);
  context.sink.error(object.position_of("direction"), "the direction of the light is 0 0 0; give one");
}

/// A picture keeps its aspect ratio; without one the light is square.
double picture_aspect(const Scene& scene, const DeltaLight& light) {
  if (!light.intensity.texture) return 1.0;
  const auto* bitmap = std::get_if<BitmapTexture>(&scene.textures[*light.intensity.texture].source);
  if (bitmap == nullptr) return 1.0;
  const Bitmap& picture = *scene.bitmaps[bitmap->bitmap];
  return static_cast<double>(picture.width) / static_cast<double>(picture.height);
}

void read_slope(const MitsubaObject& object, const Scene& scene, DeltaLight& light, const MitsubaContext& context) {
  const double half = std::tan(object.real("fov") * std::numbers::pi / 360.0), aspect = picture_aspect(scene, light);
  const std::string axis = object.text("fov_axis");
  const bool upright = axis == "y" || (axis == "smaller" && aspect > 1.0) || (axis == "larger" && aspect < 1.0);
  light.slope = upright ? glm::dvec2(half * aspect, half) : glm::dvec2(half, half / aspect);
  const std::vector<std::string> known = {"x", "y", "smaller", "larger"};
  if (std::ranges::find(known, axis) != known.end()) return;
  context.sink.error(object.position_of("fov_axis"),
                     fmt::format("{} is not an axis of a projector{}; known are: {}", text::quoted(axis),
                                 text::did_you_mean(axis, known), text::join(known)));
}

void add_picture(const XmlElement& picture, MitsubaTextures& textures, DeltaLight& light) {
  const glm::dvec3 intensity = light.intensity.value;
  light.intensity = textures.parameter({.value = glm::dvec3(1.0), .texture = &picture});
  light.intensity.value *= intensity;
}

}  // namespace

bool is_mitsuba_delta_light(std::string_view type) {
  return type == "point" || type == "spot" || type == "projector" || type == "directional";
}

DeltaLight read_mitsuba_delta_light(const MitsubaObject& object, MitsubaTextures& textures, const Scene& scene,
                                    const MitsubaContext& context) {
  DeltaLight light;
  const std::string_view type = object.type();
  light.name = type;
  light.position = object.position();
  light.world_from_light = object.matrix("to_world", RotationAxes::unit);
  const bool plane = type == "projector" || type == "directional";
  light.intensity = textures.parameter(object.color(plane ? "irradiance" : "intensity", SpectrumUse::emission));
  if (type == "point") {
    light.type = DeltaLight::Type::point;
    read_place(object, "position", context);
    if (object.given("position")) light.world_from_light[3] = glm::dvec4(object.triple("position"), 1.0);
  } else if (type == "spot") {
    light.type = DeltaLight::Type::spot;
    light.cutoff = object.real("cutoff_angle");
    light.beam_width = object.given("beam_width") ? object.real("beam_width") : 0.75 * light.cutoff;
    if (const XmlElement* picture = object.texture("texture")) add_picture(*picture, textures, light);
  } else if (type == "projector") {
    light.type = DeltaLight::Type::projector;
    // Mitsuba's "irradiance" is really the radiance of a white surface lit by the projector.
    light.intensity.value *= std::numbers::pi * object.real("scale");
    read_slope(object, scene, light, context);
  } else {
    light.type = DeltaLight::Type::directional;
    read_direction(object, light, context);
  }
  return light;
}

}  // namespace etendue
