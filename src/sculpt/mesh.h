#pragma once
/// Indexed triangles, a check of closed meshes, and the OBJ writer.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sculpt/vec.h"

namespace etendue::sculpt {

struct Mesh {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;               ///< unit; empty or one per position
  std::vector<std::array<double, 2>> uvs;  ///< empty or one per position
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Whether a triangle faces away from one of its vertex normals, as happens in creases that are finer than the mesh.
bool faces_away(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle);

/// Throws Error unless every edge is used once in each direction (so the mesh is closed, oriented and manifold), every
/// triangle has an area even after its corners are rounded to the file's digits, and at most one triangle in 1000
/// `faces_away`.
void check_closed(const Mesh& mesh);

/// A square [-0.5, 0.5]² near y = 0 with smooth waves. It has 2·n² triangles, with the smallest n that gives at least
/// `triangles`.
Mesh grid(std::uint64_t triangles);

/// `triangles` small, unconnected random triangles in the cube [-0.5, 0.5]³: the worst case for a tree.
Mesh soup(std::uint64_t triangles);

/// `triangles` small triangles over the square [-1, 1]², with y between 0.06 and 0.34, that face down, slightly tilted:
/// lamps, whose total area is about 0.075 whatever their number.
Mesh lamps(std::uint64_t triangles);

/// Writes a Wavefront OBJ file with six decimals. The file is written completely or not at all.
void write_obj(const Mesh& mesh, const std::string& title, const std::string& path);

}  // namespace etendue::sculpt
