#include "formats/gltf/gltf_lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/text.h"
#include "scene/limits.h"

namespace etendue {
namespace {

constexpr double kBlenderLumensPerWatt = 683.0;
constexpr double kDegrees = 180.0 / std::numbers::pi;

/// A right-handed frame at a node whose +Z is the node's −Z, the direction in which cameras look and lamps shine in
/// glTF. The node's scale is ignored.
glm::dmat4 looking_backward(const glm::dmat4& world_from_node, const JsonValue& where) {
  const glm::dvec3 back(world_from_node[2]), up(world_from_node[1]);
  const glm::dvec3 side = glm::cross(glm::length(up) > 0.0 ? glm::normalize(up) : up,
                                     glm::length(back) > 0.0 ? glm::normalize(back) : back);
  if (!(glm::length(side) > 0.0))
    throw GltfError{&where, "the node of a camera or a light has a transform without directions: a scale of 0"};
  const glm::dvec3 x = glm::normalize(side), z = glm::normalize(back);
  return {glm::dvec4(-x, 0.0), glm::dvec4(glm::cross(z, x), 0.0), glm::dvec4(-z, 0.0), world_from_node[3]};
}

/// Blender fades a spot over the share `blend` of 1 − cos(outer), but writes the inner angle (1 − blend) · outer.
double beam_of_blender(double inner, double outer) {
  const double edge = std::cos(outer), blend = 1.0 - inner / outer;
  return std::acos(std::min(edge + (1.0 - edge) * blend, 1.0));
}

void set_spot(const JsonValue& json, const LampRule& rule, DeltaLight& light) {
  light.type = DeltaLight::Type::spot;
  // A cubic function of the cosine, as in Blender; the standard does not prescribe one.
  light.falloff = DeltaLight::Falloff::smooth;
  const JsonValue* spot = find_object(json, "spot");
  const double inner = spot == nullptr ? 0.0 : number_or(*spot, "innerConeAngle", 0.0);
  const double outer =
      spot == nullptr ? std::numbers::pi / 4.0 : number_or(*spot, "outerConeAngle", std::numbers::pi / 4.0);
  if (!(outer > 0.0 && outer <= std::numbers::pi / 2.0 + 1e-6) || !(inner >= 0.0 && inner <= outer))
    throw GltfError{&json, fmt::format("a spot has the cone angles {} and {}; 0 <= inner <= outer <= pi/2 must hold",
                                       inner, outer)};
  light.cutoff = outer * kDegrees;
  light.beam_width = std::min((rule.fades_as_blender ? beam_of_blender(inner, outer) : inner) * kDegrees, light.cutoff);
}

void set_perspective(const JsonValue& json, Camera& camera) {
  const JsonValue* p = find_object(json, "perspective");
  if (p == nullptr) throw GltfError{&json, "the camera has no \"perspective\""};
  camera.type = Camera::Type::perspective;
  camera.fov = number_or(*p, "yfov", 0.0) * kDegrees;
  camera.fov_axis = Camera::FovAxis::y;
  if (!(camera.fov > 0.0 && camera.fov < 180.0))
    throw GltfError{
        p, fmt::format("the field of view \"yfov\" is {}; it must be between 0 and pi", number_or(*p, "yfov", 0.0))};
  camera.near_clip = std::max(number_or(*p, "znear", 0.0), 0.0);
  camera.far_clip = number_or(*p, "zfar", kMaxCoordinate);
  const double aspect = number_or(*p, "aspectRatio", 0.0);
  if (aspect > 0.0)
    camera.width = static_cast<std::uint32_t>(std::lround(std::clamp(camera.height * aspect, 1.0, 16384.0)));
}

void set_orthographic(const JsonValue& json, Camera& camera) {
  const JsonValue* o = find_object(json, "orthographic");
  if (o == nullptr) throw GltfError{&json, "the camera has no \"orthographic\""};
  const double x = std::abs(number_or(*o, "xmag", 0.0)), y = std::abs(number_or(*o, "ymag", 0.0));
  if (!(x > 0.0 && y > 0.0)) throw GltfError{o, fmt::format("the camera shows {} by {}; both must be above 0", x, y)};
  camera.type = Camera::Type::orthographic;
  // In camera space the film is two units wide, so the camera's axes are scaled by half the width.
  for (int axis = 0; axis < 3; ++axis) camera.world_from_camera[axis] *= x;
  camera.near_clip = std::max(number_or(*o, "znear", 0.0), 0.0) / x;
  camera.far_clip = number_or(*o, "zfar", kMaxCoordinate) / x;
  camera.width = static_cast<std::uint32_t>(std::lround(std::clamp(camera.height * x / y, 1.0, 16384.0)));
}

}  // namespace

LampRule lamp_rule(const JsonValue& root, GltfLamps lamps) {
  const JsonValue* asset = find_object(root, "asset");
  const std::string generator = asset == nullptr ? "" : string_or(*asset, "generator", "");
  const bool by_blender = generator.find("Blender") != std::string::npos;
  const bool divided = lamps == GltfLamps::blender || (lamps == GltfLamps::automatic && by_blender);
  return {.unit = divided ? kBlenderLumensPerWatt : 1.0,
          .unit_bulb = lamps == GltfLamps::watts ? 4.0 * std::numbers::pi : 1.0,
          .fades_as_blender = by_blender || lamps == GltfLamps::blender || lamps == GltfLamps::watts};
}

DeltaLight gltf_light(const GltfDocument& document, const JsonValue& reference, const glm::dmat4& world_from_node,
                      const LampRule& rule) {
  const auto index = find_index(reference, "light");
  const JsonValue* extension = find_extension(document.root(), "KHR_lights_punctual");
  if (!index || extension == nullptr)
    throw GltfError{&reference, "the node has a light that the document does not list"};
  const JsonValue::Array& lights = array_of(*extension, "lights");
  if (*index >= lights.size())
    throw GltfError{&reference, fmt::format("the node has light {}, of which there are {}", *index, lights.size())};
  const JsonValue& json = lights[*index];
  DeltaLight light{.position = document.position(json)};
  light.name = string_or(json, "name", fmt::format("light {}", *index));
  light.intensity = glm::max(vec3_or(json, "color", glm::dvec3(1.0)), 0.0) *
                    std::max(number_or(json, "intensity", 1.0), 0.0) / rule.unit;
  light.world_from_light = looking_backward(world_from_node, reference);
  const std::string type = string_or(json, "type", "");
  if (type != "directional") light.intensity.value /= rule.unit_bulb;
  if (type == "spot") {
    set_spot(json, rule, light);
  } else if (type == "directional") {
    light.type = DeltaLight::Type::directional;
  } else if (type != "point") {
    throw GltfError{&json,
                    fmt::format("a light has the type {}; types are point, spot and directional", text::quoted(type))};
  }
  return light;
}

void set_gltf_camera(const JsonValue& json, const glm::dmat4& world_from_node, Camera& camera) {
  camera.world_from_camera = looking_backward(world_from_node, json);
  const std::string type = string_or(json, "type", "");
  if (type == "perspective") {
    set_perspective(json, camera);
  } else if (type == "orthographic") {
    set_orthographic(json, camera);
  } else {
    throw GltfError{
        &json, fmt::format("a camera has the type {}; types are perspective and orthographic", text::quoted(type))};
  }
}

}  // namespace etendue
