#include "formats/ply/ply_writer.h"

#include <bit>
#include <cstring>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/files.h"

namespace etendue {
namespace {

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

void put(std::vector<std::byte>& bytes, const void* from, std::size_t size) {
  const std::size_t end = bytes.size();
  bytes.resize(end + size);
  std::memcpy(bytes.data() + end, from, size);
}

void put(std::vector<std::byte>& bytes, const glm::dvec3& vector) {
  put(bytes, &vector, sizeof vector);
}

}  // namespace

void write_ply(const std::string& path, const TriangleMesh& mesh) {
  if (mesh.uv_sets.size() > 1)
    throw Error(ErrorKind::scene, fmt::format("{}: the mesh has {} sets of texture coordinates; a PLY file holds one",
                                              path, mesh.uv_sets.size()));
  const bool normals = !mesh.normals.empty(), uv = !mesh.uv_sets.empty();
  const bool colors = !mesh.vertex_colors.empty(), face_colors = !mesh.face_colors.empty();
  const bool tangents = !mesh.tangents.empty();
  const char* xyzw =
      "property float tangent_x\nproperty float tangent_y\nproperty float tangent_z\nproperty float tangent_w\n";
  const bool alphas = colors && !mesh.vertex_alphas.empty();
  const char* rgb = "property float color_0\nproperty float color_1\nproperty float color_2\n";
  const std::string header = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double "
      "z\n{}{}{}{}{}element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
      mesh.positions.size(), normals ? "property double nx\nproperty double ny\nproperty double nz\n" : "",
      uv ? "property float u\nproperty float v\n" : "", colors ? rgb : "", alphas ? "property float color_3\n" : "",
      tangents ? xyzw : "", mesh.triangles.size(), face_colors ? rgb : "");
  std::vector<std::byte> bytes;
  put(bytes, header.data(), header.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    put(bytes, mesh.positions[i]);
    if (normals) put(bytes, mesh.normals[i]);
    if (uv) put(bytes, &mesh.uv_sets[0][i], sizeof(glm::vec2));
    if (colors) put(bytes, &mesh.vertex_colors[i], sizeof(glm::vec3));
    if (alphas) put(bytes, &mesh.vertex_alphas[i], sizeof(float));
    if (tangents) put(bytes, &mesh.tangents[i], sizeof(glm::vec4));
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    constexpr std::uint8_t kCorners = 3;
    put(bytes, &kCorners, 1);
    put(bytes, &mesh.triangles[i], sizeof(glm::uvec3));
    if (face_colors) put(bytes, &mesh.face_colors[i], sizeof(glm::vec3));
  }
  write_file_atomically(path, bytes);
}

}  // namespace etendue
