#pragma once
/// Textures at points of surfaces; docs/conventions.md, "Textures".

#include "reference/ray.h"
#include "scene/scene.h"

namespace etendue::reference {

/// Red, green, blue and alpha of a texture at a point.
glm::dvec4 texture_value(const Scene& scene, const Texture& texture, const Surface& surface);

/// Of a picture or a checkerboard at texture coordinates of what it lies on.
glm::dvec4 texture_value(const Scene& scene, const Texture& texture, const glm::dvec2& uv);

/// Of the first set; 0 where a mesh has none.
Vec2 first_uv(const Scene& scene, const Surface& surface);

/// A parameter at a point.
Vec3 at_point(const Scene& scene, const ColorParameter& parameter, const Surface& surface);
double at_point(const Scene& scene, const ScalarParameter& parameter, const Surface& surface);

/// How the point of a surface moves with its texture coordinates; 0 where they say nothing.
struct Tangents {
  Vec3 u{0.0}, v{0.0};
};
/// `set`: of texture coordinates.
Tangents tangents(const Scene& scene, std::uint32_t set, const Surface& surface);
/// The tangent of the mesh's vertices, and in w which side of normal × tangent the bitangent is on, 1 or −1.
glm::dvec4 vertex_tangent(const Scene& scene, const Surface& surface);
/// How a picture's number changes with those coordinates, interpolated bilinearly.
Vec2 gradient_at(const Scene& scene, const ScalarParameter& parameter, const Surface& surface);

/// A material at a point: all of its parameters are constants.
Bsdf at_point(const Scene& scene, const Bsdf& bsdf, const Surface& surface);

}  // namespace etendue::reference
