#pragma once
/// For the targets that read meshes: any bytes must give a valid mesh or an error.

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "inputs.h"
#include "scene/diagnostics.h"
#include "scene/placed.h"

namespace etendue::fuzz {

inline void require_sound(const TriangleMesh& mesh) {
  require(mesh.triangles.empty() == mesh.positions.empty());
  require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) require(std::max({t.x, t.y, t.z}) < mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  for (const glm::dvec3& n : mesh.normals) require(std::abs(glm::length(n) - 1.0) < 1e-6);
  for (const auto& uvs : mesh.uv_sets) {
    require(uvs.size() == mesh.positions.size());
    for (const glm::vec2& uv : uvs) require(std::isfinite(uv.x) && std::isfinite(uv.y));
  }
  require(mesh.face_colors.empty() || mesh.face_colors.size() == mesh.triangles.size());
  require(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.positions.size());
}

/// Requires that a mesh is valid, also where it is placed.
inline void require_sound(const PlacedMesh& mesh) {
  for (std::uint32_t i = 0; i < mesh.mesh().positions.size(); ++i) {
    const glm::dvec3 p = mesh.position(i);
    require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    if (mesh.has_normals()) require(std::abs(glm::length(mesh.normal(i)) - 1.0) < 1e-6);
  }
  for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
    const glm::uvec3 t = mesh.indices(i);
    require(std::max({t.x, t.y, t.z}) < mesh.mesh().positions.size());
  }
}

/// `read(source, diagnostics)` is the reader. The first byte chooses the size of the reads and the transform of the
/// mesh.
template <typename Read>
void read_any_mesh(const std::uint8_t* data, std::size_t size, const Read& read) {
  if (size == 0) return;
  Instance instance;
  glm::dmat4& m = instance.world_from_object;
  if ((*data & 4) != 0) m = glm::scale(m, glm::dvec3(-1e-9, 2.0, 1e6));
  if ((*data & 8) != 0) m = glm::rotate(m, 1.0, glm::dvec3(1.0, 2.0, 3.0));
  instance.flip_normals = (*data & 16) != 0;
  Diagnostics diagnostics;
  const auto mesh = read(source_of(data, size), diagnostics);
  require(mesh.has_value() != diagnostics.has_errors());
  if (!mesh) return;
  require_sound(*mesh);
  require_sound(PlacedMesh(*mesh, instance));
}

}  // namespace etendue::fuzz
