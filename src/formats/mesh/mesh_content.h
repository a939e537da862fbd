#pragma once
/// What readers of mesh files have in common besides positions, normals and triangles.

#include <string>

#include <glm/glm.hpp>

#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// What of a mesh file is wanted beside its surface. What nothing uses costs no memory, and splits no vertices.
struct MeshContent {
  bool uv = true;
  bool textured = true;  ///< textures use them, or else only the direction of materials
  bool colors = true;
  bool tangents = false;  ///< those that PLY files of ours have
  /// Of PLY files: what is read as colours instead, the properties NAME_0 to NAME_2, or NAME_0 alone as grey.
  std::string attribute = {};
  std::size_t attributes = 0;  ///< that are wanted; a mesh brings one
};

/// Point tests of ear clipping allowed per file: some ten seconds. A hostile file of huge comb-shaped polygons ends
/// there.
inline constexpr std::int64_t kMaxPolygonWork = 3'000'000'000;
/// Of one face.
inline constexpr std::size_t kMaxCorners = 65536;

/// A colour of an integer file or of an OBJ file, in [0,1]: both are written as they are shown on screens (IEC
/// 61966-2-1).
glm::vec3 linear_from_srgb(const glm::vec3& color);

void warn_degenerate(const TriangleMesh& mesh, const std::string& file, Diagnostics& diagnostics);

/// Leaves out the vertices that no triangle has; the others keep their order.
void drop_unused_vertices(TriangleMesh& mesh);

/// Positions and normals in single precision where that changes none of them.
void narrow_vectors(TriangleMesh& mesh);

/// A unit normal a vertex: the mean of the normals of its triangles, weighted by their angles there [Thurmer1998].
/// Vertices at the same place are not joined. One without a triangle that has an area gets +z.
void make_smooth_normals(TriangleMesh& mesh);

}  // namespace etendue
