#include "formats/nori/plugins.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;

constexpr Range kColor{-1000, 1000, false, false};
constexpr Range kFactor{0, kMaxRadiance, false, false};
constexpr Range kCoordinate{-kMaxTextureCoordinate, kMaxTextureCoordinate, false, false};

Parameter to_uv() {
  return {"to_uv", transform, "", {}, "from texture coordinates of the surface to those of the texture; z is not used"};
}
Parameter uv_scale() {
  return {"uvscale", real, "1", kCoordinate, "factor of the texture coordinates"};
}
Parameter factor() {
  return {"scale", color, "1 1 1", kFactor, "factor for the colours"};
}

/// Operations on the value of a texture.
std::vector<Parameter> derived(bool may_be_tinted) {
  std::vector<Parameter> rows;
  if (may_be_tinted)
    rows.push_back({"vertex_tint", boolean, "false", {}, "multiply with the colours and alpha of the mesh's vertices"});
  rows.push_back({"alpha_cutoff", real, "", kColor, "threshold: alpha becomes 1 from this value on, 0 below it"});
  rows.push_back({"premultiplied", boolean, "false", {}, "multiply the colours with alpha"});
  return rows;
}

Parameter channel() {
  return {"channel", string, "luminance", {}, "the channel to use as a number: red, green, blue, alpha or luminance"};
}

}  // namespace

std::vector<Plugin> texture_plugins() {
  std::vector<Plugin> rows = {
      {"texture",
       "bitmap",
       "A picture: PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR. Its first row is at the top, at v = 1.",
       {{"filename", string, nullptr, {}, "the picture, relative to the folder of the scene file"},
        {"wrap_mode", string, "repeat", {}, "beyond the edges: repeat, mirror or clamp"},
        {"filter_type", string, "bilinear", {}, "between texels: bilinear or nearest"},
        {"raw", boolean, "false", {}, "8-bit values are plain numbers, not sRGB-encoded colours"},
        {"tile", vector2, "1 1", kCoordinate, "size of the picture in texture coordinates, not 0"},
        {"delta", point2, "0 0", kCoordinate, "offset in pictures: lookups are at uv / tile − delta"},
        uv_scale(),
        to_uv(),
        factor()},
       {}},
      {"texture",
       "checkerboard",
       "Squares of side 1/2 in texture coordinates.",
       {{"color0", color, "0.4 0.4 0.4", kColor, "colour of the square at (0,0) and of those that touch it at a corner",
         "texture"},
        {"color1", color, "0.2 0.2 0.2", kColor, "colour of the others", "texture"},
        uv_scale(),
        to_uv(),
        factor()},
       {}},
      {"texture",
       "checkerboard_color",
       "Nori's checkerboard: squares of side 1 in uv / scale − delta.",
       {{"value1", color, "0 0 0", kColor, "colour of the square at (0,0) and of those that touch it at a corner"},
        {"value2", color, "1 1 1", kColor, "colour of the others"},
        {"scale", vector2, "1 1", kCoordinate, "size of the squares, not 0"},
        {"delta", point2, "0 0", kCoordinate, "offset in squares"}},
       {}},
      {"texture",
       "checker",
       "The checkerboard of one course: squares of side 1 in texture coordinates times scalex and scaley.",
       {{"color0", color, "0.9 0.9 0.9", kColor,
         "colour of the square at (0,0) and of those that touch it at a corner"},
        {"color1", color, "0.1 0.1 0.1", kColor, "colour of the others"},
        {"scalex", real, "1", kCoordinate, "squares along u, not 0"},
        {"scaley", real, "1", kCoordinate, "squares along v, not 0"}},
       {}},
      {"texture", "constant_color", "A constant colour.", {{"value", color, "1 1 1", kColor, "the colour"}}, {}},
      {"texture",
       "mesh_attribute",
       "Colours stored in the mesh's file.",
       {{"attribute", string, "vertex_color", {}, "vertex_color, which is interpolated, or face_color"}, factor()},
       {}},
  };
  for (Plugin& row : rows) {
    const bool attribute = std::string_view(row.type) == "mesh_attribute";
    if (attribute || std::string_view(row.type) == "bitmap" || std::string_view(row.type) == "checkerboard") {
      for (const Parameter& parameter : derived(!attribute)) row.parameters.push_back(parameter);
    }
    row.parameters.push_back(channel());
  }
  return rows;
}

}  // namespace etendue
