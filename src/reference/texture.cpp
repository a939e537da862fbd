#include "reference/texture.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <type_traits>

#include "reference/frame.h"
#include "reference/placement.h"
#include "reference/sampling.h"
#include "scene/limits.h"
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

/// `surface_uv` is where the surface is, `uv` where the checkerboard is.
Vec4 value(const CheckerboardTexture& board, const Scene& scene, const Vec2& uv, const Vec2& surface_uv) {
  const bool even = std::fmod(std::floor(2.0 * uv.x) + std::floor(2.0 * uv.y), 2.0) == 0.0;
  const Vec3 color = even ? board.color0 : board.color1;
  const std::optional<std::uint32_t>& within = even ? board.texture0 : board.texture1;
  if (!within) return Vec4(color, 1.0);
  return Vec4(color, 1.0) * texture_value(scene, scene.textures[*within], surface_uv);
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
  Vec4 color(0.0);
  for (int k = 0; k < 3; ++k) {
    const double alpha = mesh.vertex_alphas.empty() ? 1.0 : static_cast<double>(mesh.vertex_alphas[t[k]]);
    color += surface.weights[k] * Vec4(Vec3(mesh.vertex_colors[t[k]]), alpha);
  }
  return color;
}

Vec2 sphere_uv(const Instance& instance, const Surface& surface) {
  const Vec3 outward = instance.flip_normals ? -surface.ns : surface.ns;
  const Vec3 d = glm::normalize(glm::inverse(glm::dmat3(instance.world_from_object)) * outward);
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

double channel(const Vec4& value, TextureChannel which) {
  return which == TextureChannel::luminance ? luminance(Vec3(value)) : value[static_cast<int>(which)];
}

/// Of p = c + r (sin θ cos φ, sin θ sin φ, cos θ) in the sphere's own frame, φ = 2π u, θ = π − π v.
Tangents sphere_tangents(const Sphere& sphere, const Instance& instance, const Vec3& n) {
  glm::dmat3 axes(instance.world_from_object);
  for (int k = 0; k < 3; ++k) axes[k] = glm::normalize(axes[k]);
  const Vec3 d = glm::transpose(axes) * n;
  const double sin_theta = std::hypot(d.x, d.y);
  if (!(sin_theta > 0.0)) return {};
  const Vec3 by_phi(-d.y, d.x, 0.0), by_theta(d.z * d.x / sin_theta, d.z * d.y / sin_theta, -sin_theta);
  return {axes * (2.0 * kPi * sphere.radius * by_phi), axes * (-kPi * sphere.radius * by_theta)};
}

/// Of p = c + r (cos φ a + sin φ b), u = r, φ = 2π (1 − v).
Tangents disk_tangents(const Instance& instance, const Surface& surface) {
  const Vec3 p = object_point(instance, surface.p);
  const double r = std::hypot(p.x, p.y);
  if (!(r > 0.0)) return {};
  const glm::dmat3 axes(instance.world_from_object);
  return {axes * Vec3(p.x / r, p.y / r, 0.0), axes * (-2.0 * kPi * Vec3(-p.y, p.x, 0.0))};
}

/// Of p = p0 + r (cos φ s + sin φ t) + (1 − v) (p1 − p0), φ = 2π u.
Tangents cylinder_tangents(const Cylinder& cylinder, const Instance& instance, const Surface& surface) {
  const Vec3 axis = cylinder.p1 - cylinder.p0;
  const Frame frame(glm::normalize(axis));
  const Vec3 local = frame.to_local(object_point(instance, surface.p) - cylinder.p0);
  const glm::dmat3 axes(instance.world_from_object);
  return {axes * frame.to_world(2.0 * kPi * Vec3(-local.y, local.x, 0.0)), axes * -axis};
}

}  // namespace

Vec2 first_uv(const Scene& scene, const Surface& surface) {
  const Instance& instance = scene.instances[surface.instance];
  const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance));
  if (mesh != nullptr && mesh->uv_sets.empty()) return Vec2(0.0);
  return surface_uv(scene, 0, surface);
}

glm::dvec4 texture_value(const Scene& scene, const Texture& texture, const Surface& surface) {
  const Instance& instance = scene.instances[surface.instance];
  const auto colors = [&](const AttributeTexture& attribute) {
    return value(attribute, std::get<TriangleMesh>(scene.shape_of(instance)), instance, surface);
  };
  const auto* attribute = std::get_if<AttributeTexture>(&texture.source);
  Vec4 result = attribute != nullptr ? colors(*attribute)
                                     : texture_value(scene, texture, surface_uv(scene, texture.uv_set, surface));
  if (texture.vertex_tint) result *= colors(AttributeTexture{AttributeTexture::Source::vertex_color});
  if (texture.alpha_cutoff) result.a = result.a < *texture.alpha_cutoff ? 0.0 : 1.0;
  return texture.premultiplied ? Vec4(Vec3(result) * result.a, result.a) : result;
}

glm::dvec4 texture_value(const Scene& scene, const Texture& texture, const glm::dvec2& surface_uv) {
  const Vec2 uv(texture.uv_transform * Vec3(surface_uv, 1.0));
  if (const auto* board = std::get_if<CheckerboardTexture>(&texture.source))
    return value(*board, scene, uv, surface_uv);
  return value(std::get<BitmapTexture>(texture.source), scene, uv);
}

Vec3 at_point(const Scene& scene, const ColorParameter& parameter, const Surface& surface) {
  if (!parameter.texture) return parameter.value;
  return parameter.value * Vec3(texture_value(scene, scene.textures[*parameter.texture], surface));
}

double at_point(const Scene& scene, const ScalarParameter& parameter, const Surface& surface) {
  if (!parameter.texture) return parameter.value;
  return parameter.value *
         channel(texture_value(scene, scene.textures[*parameter.texture], surface), parameter.channel);
}

Tangents tangents(const Scene& scene, std::uint32_t set, const Surface& surface) {
  const Instance& instance = scene.instances[surface.instance];
  const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance));
  const Shape& shape = scene.shape_of(instance);
  if (std::holds_alternative<Disk>(shape)) return disk_tangents(instance, surface);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return cylinder_tangents(*cylinder, instance, surface);
  if (mesh == nullptr)
    return sphere_tangents(Placement(instance).sphere(std::get<Sphere>(scene.shape_of(instance))), instance,
                           instance.flip_normals ? -surface.ns : surface.ns);
  if (set >= mesh->uv_sets.size()) return {};
  const glm::uvec3 t = corners(*mesh, instance, surface);
  const std::vector<glm::vec2>& uvs = mesh->uv_sets[set];
  const std::array<Vec3, 3> p = Placement(instance).triangle(*mesh, surface.primitive);
  // [dp/du dp/dv] times the columns of the edges' coordinates are the edges.
  const glm::dmat2 coordinates(Vec2(uvs[t.y]) - Vec2(uvs[t.x]), Vec2(uvs[t.z]) - Vec2(uvs[t.x]));
  if (glm::determinant(coordinates) == 0.0) return {};
  const glm::dmat2 inverse = glm::inverse(coordinates);
  const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
  return {inverse[0][0] * e1 + inverse[0][1] * e2, inverse[1][0] * e1 + inverse[1][1] * e2};
}

glm::dvec4 vertex_tangent(const Scene& scene, const Surface& surface) {
  const Instance& instance = scene.instances[surface.instance];
  const auto& mesh = std::get<TriangleMesh>(scene.shape_of(instance));
  const glm::uvec3 t = corners(mesh, instance, surface);
  const glm::dmat3 linear(instance.world_from_object);
  Vec3 sum(0.0);
  double side = 0.0;
  for (int k = 0; k < 3; ++k) {
    const glm::dvec4 tangent(mesh.tangents[t[k]]);
    sum += surface.weights[k] * (linear * Vec3(tangent));
    side += surface.weights[k] * tangent.w;
  }
  // A mirror image shows the mirror image of its texture; normals that are flipped turn the bitangent once more.
  return {sum, (side < 0.0) != Placement(instance).turned() ? -1.0 : 1.0};
}

Vec2 gradient_at(const Scene& scene, const ScalarParameter& parameter, const Surface& surface) {
  const Texture& texture = scene.textures[*parameter.texture];
  const auto& picture = std::get<BitmapTexture>(texture.source);
  const Bitmap& bitmap = *scene.bitmaps[picture.bitmap];
  const bool srgb = picture.color_space.value_or(bitmap.color_space) == ColorSpace::srgb;
  const Vec2 uv(texture.uv_transform * Vec3(surface_uv(scene, texture.uv_set, surface), 1.0));
  const double x = uv.x * bitmap.width - 0.5, y = (1.0 - uv.y) * bitmap.height - 0.5;
  const double i = std::floor(x), j = std::floor(y), s = x - i, t = y - j;
  const auto at = [&](double column, double row) {
    return channel(
        texel(bitmap, srgb, wrapped(column, bitmap.width, picture.wrap_u), wrapped(row, bitmap.height, picture.wrap_v)),
        parameter.channel);
  };
  const double by_x = (1.0 - t) * (at(i + 1.0, j) - at(i, j)) + t * (at(i + 1.0, j + 1.0) - at(i, j + 1.0));
  const double by_y = (1.0 - s) * (at(i, j + 1.0) - at(i, j)) + s * (at(i + 1.0, j + 1.0) - at(i + 1.0, j));
  // By the chain rule through the texture's transform; rows count against v.
  const Vec2 by_uv(by_x * bitmap.width, -by_y * bitmap.height);
  return parameter.value * (glm::transpose(glm::dmat2(texture.uv_transform)) * by_uv);
}

Bsdf at_point(const Scene& scene, const Bsdf& bsdf, const Surface& surface) {
  Bsdf constant = bsdf;
  std::visit(
      [&](auto& of_type) {
        each_parameter(of_type, [&](const char* name, auto& parameter) {
          if (!parameter.texture) return;
          const ParameterRange range = parameter_range(of_type, name);
          const std::optional<std::uint32_t> texture = parameter.texture;
          parameter = at_point(scene, parameter, surface);
          parameter.value = glm::clamp(parameter.value, range.least, range.most);
          // A rough coat asks whether its roughness varies.
          if (std::is_same_v<std::remove_cvref_t<decltype(of_type)>, RoughPlasticBsdf> &&
              name == std::string_view("alpha"))
            parameter.texture = texture;
        });
      },
      constant);
  auto* gltf = std::get_if<GltfBsdf>(&constant);
  if (gltf != nullptr && std::get<GltfBsdf>(bsdf).anisotropy_directions.texture) {
    const Vec3 direction = 2.0 * gltf->anisotropy_directions.value - 1.0;
    gltf->anisotropy_rotation += std::atan2(direction.y, direction.x);
  }
  return constant;
}

}  // namespace etendue::reference
