#pragma once
/// Cutting polygons into triangles.

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// Corners of a triangle as indices into the polygon.
using PolygonTriangle = glm::uvec3;

/// Cuts a simple, roughly planar polygon of n >= 3 corners into n − 2 triangles of the same orientation, appended to
/// `triangles`. Convex polygons become a fan around corner 0; others are cut ear by ear in the plane of their area
/// vector [Meisters1975], O(n²). A polygon that crosses itself still gives n − 2 triangles; the return value is false
/// then. `work` is reduced by the number of points tested; when it reaches 0 the rest becomes a fan and false is
/// returned.
bool triangulate(std::span<const glm::dvec3> polygon, std::vector<PolygonTriangle>& triangles, std::int64_t& work);

}  // namespace etendue
