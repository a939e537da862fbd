#include "cli/path_words.h"

#include <fmt/core.h>

#include "reference/bsdf.h"

namespace etendue::cli {
namespace {

constexpr std::uint32_t kNone = PathVertex::kNone;

const char* lobe_name(const PathVertex& vertex) {
  if (vertex.lobe == kNone) return "-";
  switch (static_cast<reference::Lobe>(vertex.lobe)) {
    case reference::Lobe::none:
      return "none";
    case reference::Lobe::diffuse_reflection:
      return "diffuse";
    case reference::Lobe::delta_reflection:
      return "reflection";
    case reference::Lobe::delta_transmission:
      return "transmission";
    case reference::Lobe::glossy_reflection:
      return "glossy";
    case reference::Lobe::glossy_transmission:
      return "glossy through";
    case reference::Lobe::passed:
      return "passed";
    case reference::Lobe::diffuse_transmission:
      return "diffuse through";
  }
  return "-";
}

std::string place(std::uint32_t instance, std::uint32_t primitive, const char* none) {
  if (instance == PathVertex::kEnvironment) return fmt::format("sky, {}", primitive);
  if (instance == PathVertex::kDeltaLight) return fmt::format("light {}", primitive);
  return instance == kNone ? none : fmt::format("instance {}, {}", instance, primitive);
}

const char* yes_no(std::uint32_t decision) {
  return decision == kNone ? "-" : decision == 1 ? "yes" : "no";
}

Json number_or_null(std::uint32_t value) {
  return value == kNone ? Json() : Json(value);
}

}  // namespace

Json light_json(std::uint32_t instance) {
  if (instance == PathVertex::kEnvironment) return "sky";
  if (instance == PathVertex::kDeltaLight) return "point";
  return instance == kNone ? Json() : Json(instance);
}

VertexWords words_of(const PathVertex& v) {
  return {place(v.instance, v.primitive, "nothing"), place(v.light_instance, v.light_primitive, "-"),
          yes_no(v.light_contributed), lobe_name(v), yes_no(v.survived)};
}

Json to_json(const PathVertex& v) {
  return {{"instance", number_or_null(v.instance)},
          {"primitive", number_or_null(v.primitive)},
          {"lightInstance", light_json(v.light_instance)},
          {"lightPrimitive", number_or_null(v.light_primitive)},
          {"lightReached", number_or_null(v.light_contributed)},
          {"lobe", lobe_name(v)},
          {"survived", number_or_null(v.survived)},
          {"from", {v.from.x, v.from.y, v.from.z}},
          {v.instance == kNone ? "direction" : "to", {v.to.x, v.to.y, v.to.z}},
          {"radiance", {v.radiance.x, v.radiance.y, v.radiance.z}}};
}

}  // namespace etendue::cli
