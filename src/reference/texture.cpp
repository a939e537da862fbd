#include "reference/texture.h"

#include <algorithm>
#include <cmath>

#include "reference/frame.h"
#include "reference/placement.h"
#include "reference/sampling.h"
#include "scene/parameters.h"

namespace etendue::reference {
namespace {

using Vec4 = glm::dvec4;

/// The texel of a row of `n` that an index stands for, however far outside.
std::uint32_t wrapped(double index, std::uint32_t n, TextureWrap wrap) {
  const double size = n;
  double i = index;
  switch (wrap) {
    case TextureWrap::repeat:
      i = index - size * std::floor(index / size);
      break;
    case TextureWrap::mirror:
      i = index - 2.0 * size * std::floor(index / (2.0 * size));
      if (i >= size) i = 2.0 * size - 1.0 - i;
      break;
    case TextureWrap::clamp:
      break;
  }
  return static_cast<std::uint32_t>(std::clamp(i, 0.0, size - 1.0));
}

double light_of_code(double code) {  // IEC 61966-2-1
  constexpr double kLinearBelow = 0.04045, kOffset = 0.055;
  return code > kLinearBelow ? std::pow((code + kOffset) / (1.0 + kOffset), 2.4) : code / 12.92;
}

Vec4 texel(const Bitmap& bitmap, bool srgb, std::uint32_t x, std::uint32_t y) {
  double c[4] = {0.0, 0.0, 0.0, 1.0};
  const bool alpha = bitmap.channels % 2 == 0;
  const std::uint32_t colors = alpha ? bitmap.channels - 1 : bitmap.channels;
  for (std::uint32_t i = 0; i < 3; ++i) {
    const double stored = static_cast<double>(bitmap.stored(x, y, std::min(i, colors - 1)));
    c[i] = srgb ? light_of_code(stored) : stored;
  }
  if (alpha) c[3] = static_cast<double>(bitmap.stored(x, y, colors));
  return {c[0], c[1], c[2], c[3]};
}

Vec4 value(const BitmapTexture& texture, const Scene& scene, const Vec2& uv) {
  const Bitmap& bitmap = *scene.bitmaps[texture.bitmap];
  const bool srgb = texture.color_space.value_or(bitmap.color_space) == ColorSpace::srgb;
  const auto at = [&](double i, double j) {
    return texel(bitmap, srgb, wrapped(i, bitmap.width, texture.wrap_u), wrapped(j, bitmap.height, texture.wrap_v));
  };
  const double x = uv.x * bitmap.width, y = (1.0 - uv.y) * bitmap.height;  // rows count from the top
  if (texture.filter == TextureFilter::nearest) return at(std::floor(x), std::floor(y));
  // Weights fall off linearly from the centres, which lie at i + 1/2.
  const double i = std::floor(x - 0.5), j = std::floor(y - 0.5);
  const double s = x - 0.5 - i, t = y - 0.5 - j;
  return (1.0 - s) * (1.0 - t) * at(i, j) + s * (1.0 - t) * at(i + 1.0, j) + (1.0 - s) * t * at(i, j + 1.0) +
         s * t * at(i + 1.0, j + 1.0);
}

Vec4 value(const CheckerboardTexture& board, const Vec2& uv) {
  const bool even = std::fmod(std::floor(2.0 * uv.x) + std::floor(2.0 * uv.y), 2.0) == 0.0;
  return Vec4(even ? board.color0 : board.color1, 1.0);
}

/// The vertices of the surface's triangle, in the order of its weights.
glm::uvec3 corners(const TriangleMesh& mesh, const Instance& instance, const Surface& surface) {
  return Placement(instance).ordered(mesh.triangles[surface.primitive]);
}

Vec4 value(const AttributeTexture& attribute, const TriangleMesh& mesh, const Instance& instance,
           const Surface& surface) {
  if (attribute.source == AttributeTexture::Source::face_color)
    return Vec4(glm::dvec3(mesh.face_colors[surface.primitive]), 1.0);
  const glm::uvec3 t = corners(mesh, instance, surface);
  Vec3 color(0.0);
  for (int k = 0; k < 3; ++k) color += surface.weights[k] * Vec3(mesh.vertex_colors[t[k]]);
  return Vec4(color, 1.0);
}

Vec2 sphere_uv(const Instance& instance, const Surface& surface) {
  const Vec3 d = glm::normalize(glm::inverse(glm::dmat3(instance.world_from_object)) * surface.ns);
  const double turns = std::atan2(d.y, d.x) / (2.0 * kPi);
  return {turns < 0.0 ? turns + 1.0 : turns, 1.0 - std::acos(std::clamp(d.z, -1.0, 1.0)) / kPi};
}

/// The angle of (x, y) from the x axis, as a share of a turn in [0,1).
double turn(double x, double y) {
  const double turns = std::atan2(y, x) / (2.0 * kPi);
  return turns < 0.0 ? turns + 1.0 : turns;
}

Vec3 object_point(const Instance& instance, const Vec3& p) {
  return Vec3(glm::inverse(instance.world_from_object) * Vec4(p, 1.0));
}

/// Polar coordinates.
Vec2 disk_uv(const Instance& instance, const Surface& surface) {
  const Vec3 p = object_point(instance, surface.p);
  return {std::hypot(p.x, p.y), 1.0 - turn(p.x, p.y)};
}

Vec2 cylinder_uv(const Cylinder& cylinder, const Instance& instance, const Surface& surface) {
  const Vec3 axis = cylinder.p1 - cylinder.p0;
  const double height = glm::length(axis);
  const Vec3 local = Frame(axis / height).to_local(object_point(instance, surface.p) - cylinder.p0);
  return {turn(local.x, local.y), 1.0 - local.z / height};
}

Vec2 surface_uv(const Scene& scene, std::uint32_t set, const Surface& surface) {
  const Instance& instance = scene.instances[surface.instance];
  const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance));
  if (std::holds_alternative<Disk>(scene.shape_of(instance))) return disk_uv(instance, surface);
  if (const auto* cylinder = std::get_if<Cylinder>(&scene.shape_of(instance)))
    return cylinder_uv(*cylinder, instance, surface);
  if (mesh == nullptr) return sphere_uv(instance, surface);
  const glm::uvec3 t = corners(*mesh, instance, surface);
  Vec2 uv(0.0);
  for (int k = 0; k < 3; ++k) uv += surface.weights[k] * Vec2(mesh->uv_sets[set][t[k]]);
  return uv;
}

}  // namespace

glm::dvec4 texture_value(const Scene& scene, const Texture& texture, const Surface& surface) {
  if (const auto* attribute = std::get_if<AttributeTexture>(&texture.source)) {
    const Instance& instance = scene.instances[surface.instance];
    return value(*attribute, std::get<TriangleMesh>(scene.shape_of(instance)), instance, surface);
  }
  return texture_value(scene, texture, surface_uv(scene, texture.uv_set, surface));
}

glm::dvec4 texture_value(const Scene& scene, const Texture& texture, const glm::dvec2& surface_uv) {
  const Vec2 uv(texture.uv_transform * Vec3(surface_uv, 1.0));
  if (const auto* board = std::get_if<CheckerboardTexture>(&texture.source)) return value(*board, uv);
  return value(std::get<BitmapTexture>(texture.source), scene, uv);
}

Vec3 at_point(const Scene& scene, const ColorParameter& parameter, const Surface& surface) {
  if (!parameter.texture) return parameter.value;
  return parameter.value * Vec3(texture_value(scene, scene.textures[*parameter.texture], surface));
}

double at_point(const Scene& scene, const ScalarParameter& parameter, const Surface& surface) {
  if (!parameter.texture) return parameter.value;
  const Vec4 v = texture_value(scene, scene.textures[*parameter.texture], surface);
  if (parameter.channel == TextureChannel::luminance) return parameter.value * luminance(Vec3(v));
  return parameter.value * v[static_cast<int>(parameter.channel)];
}

Bsdf at_point(const Scene& scene, const Bsdf& bsdf, const Surface& surface) {
  Bsdf constant = bsdf;
  each_parameter(constant, [&](const char*, auto& parameter) {
    if (parameter.texture) parameter = at_point(scene, parameter, surface);
  });
  return constant;
}

}  // namespace etendue::reference
