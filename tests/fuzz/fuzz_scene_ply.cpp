/// Any bytes as a PLY file: the reader ends with a sound mesh or with an error, never with a fault.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include <glm/gtc/matrix_transform.hpp>

#include "formats/ply/ply_reader.h"
#include "scene/placed.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void require_sound(const etendue::TriangleMesh& mesh) {
  require(mesh.triangles.empty() == mesh.positions.empty());
  require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) require(std::max({t.x, t.y, t.z}) < mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
  for (const glm::dvec3& n : mesh.normals) require(std::abs(glm::length(n) - 1.0) < 1e-6);
  for (const auto& uvs : mesh.uv_sets) {
    require(uvs.size() == mesh.positions.size());
    for (const glm::vec2& uv : uvs) require(std::isfinite(uv.x) && std::isfinite(uv.y));
  }
  require(mesh.vertex_colors.empty() || mesh.vertex_colors.size() == mesh.positions.size());
  require(mesh.face_colors.empty() || mesh.face_colors.size() == mesh.triangles.size());
}

/// A sound mesh stays one wherever it is placed.
void require_sound(const etendue::PlacedMesh& mesh) {
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

}  // namespace

/// The first byte chooses the size of the reads and the place of the mesh.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t chunk = (*data & 3) == 0 ? 1 : std::size_t{1} << (2 * (*data & 3));
  etendue::Instance instance;
  glm::dmat4& m = instance.world_from_object;
  if ((*data & 4) != 0) m = glm::scale(m, glm::dvec3(-1e-9, 2.0, 1e6));
  if ((*data & 8) != 0) m = glm::rotate(m, 1.0, glm::dvec3(1.0, 2.0, 3.0));
  instance.flip_normals = (*data & 16) != 0;
  std::size_t at = 1;
  const etendue::ByteSource source = [&](char* buffer, std::size_t capacity) {
    const std::size_t count = std::min({capacity, chunk, size - at});
    std::memcpy(buffer, data + at, count);
    at += count;
    return count;
  };
  etendue::Diagnostics diagnostics;
  const auto mesh = etendue::read_ply(source, "fuzz.ply", {}, diagnostics, size);
  require(mesh.has_value() != diagnostics.has_errors());
  if (!mesh) return 0;
  require_sound(*mesh);
  require_sound(etendue::PlacedMesh(*mesh, instance));
  return 0;
}
