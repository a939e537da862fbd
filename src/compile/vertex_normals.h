#pragma once
/// Vertex normals in few bits.

#include <glm/glm.hpp>

#include "gpu_types.h"

namespace etendue {

/// The texel of a triangle with these unit normals at its corners, as shaders/vertex_normals.glsl reads it: each as a
/// point of the octahedron, folded into a square [Meyer2010]. None turns by more than 2.1e-6 radians; normals along
/// axes and diagonals are exact.
gpu::uvec4 pack_normals(const glm::dvec3& n0, const glm::dvec3& n1, const glm::dvec3& n2);

}  // namespace etendue
