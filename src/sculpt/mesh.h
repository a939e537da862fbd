#pragma once
/// Indexed triangles, their self-check and their file.

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

/// True when a triangle looks away from one of its vertex normals, as happens in creases finer than the mesh.
bool faces_away(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle);

/// Throws Error unless every edge is used once in each direction (closed, oriented, manifold), every triangle has an
/// area even with its corners rounded to the file's digits, and at most one triangle in 1000 `faces_away`.
void check_closed(const Mesh& mesh);

/// A flat square [-0.5, 0.5]² in y = 0 with 2·n² triangles, n the least that gives `triangles`; smooth waves on it.
Mesh grid(std::uint64_t triangles);

/// `triangles` small random triangles in the cube [-0.5, 0.5]³, with nothing between them: the worst case for a
/// hierarchy.
Mesh soup(std::uint64_t triangles);

/// `triangles` small triangles that hover over the square [-1, 1]², y between 0.06 and 0.34, and look down, a little
/// aside: lamps of about 0.075 area in all, whatever their number.
Mesh lamps(std::uint64_t triangles);

/// Writes a Wavefront OBJ file with six decimals; the file appears whole or not at all.
void write_obj(const Mesh& mesh, const std::string& title, const std::string& path);

}  // namespace etendue::sculpt
