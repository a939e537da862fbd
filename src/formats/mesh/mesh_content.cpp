#include "formats/mesh/mesh_content.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/placed.h"

namespace etendue {
namespace {

constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

float linear_from_srgb(float c) {
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

/// `place[i]` is the new number of element i, not above i, or kUnused.
template <typename T>
void compact(std::vector<T>& elements, const std::vector<std::uint32_t>& place, std::size_t count) {
  if (elements.empty()) return;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] != kUnused) elements[place[i]] = elements[i];
  }
  elements.resize(count);
}

void compact(VectorList& vectors, const std::vector<std::uint32_t>& place, std::size_t count) {
  compact(vectors.edit(), place, count);
  vectors.narrow();
}

}  // namespace

glm::vec3 linear_from_srgb(const glm::vec3& color) {
  return {linear_from_srgb(color.x), linear_from_srgb(color.y), linear_from_srgb(color.z)};
}

void warn_degenerate(const TriangleMesh& mesh, const std::string& file, Diagnostics& diagnostics) {
  const auto degenerate = std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                        [&](const glm::uvec3& t) { return !(triangle_area(mesh, t) > 0.0); });
  if (degenerate == 0) return;
  diagnostics.warning({file, 0, 0}, fmt::format("{} of {} triangles have no area; no ray hits them", degenerate,
                                                mesh.triangles.size()));
}

void drop_unused_vertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> place(mesh.positions.size(), kUnused);
  for (const glm::uvec3& t : mesh.triangles) place[t.x] = place[t.y] = place[t.z] = 0;
  std::uint32_t count = 0;
  for (std::uint32_t& p : place) {
    if (p != kUnused) p = count++;
  }
  if (count == place.size()) return;
  compact(mesh.positions, place, count);
  compact(mesh.normals, place, count);
  for (std::vector<glm::vec2>& uvs : mesh.uv_sets) compact(uvs, place, count);
  compact(mesh.vertex_colors, place, count);
  compact(mesh.vertex_alphas, place, count);
  compact(mesh.tangents, place, count);
  for (glm::uvec3& t : mesh.triangles) t = {place[t.x], place[t.y], place[t.z]};
}

void narrow_vectors(TriangleMesh& mesh) {
  mesh.positions.narrow();
  mesh.normals.narrow();
}

void make_smooth_normals(TriangleMesh& mesh) {
  std::vector<glm::dvec3> normals(mesh.positions.size(), glm::dvec3(0.0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 p[3] = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
    const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double doubled_area = glm::length(cross);
    if (!(doubled_area > 0.0)) continue;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 a = p[(i + 1) % 3] - p[i], b = p[(i + 2) % 3] - p[i];
      const double angle = std::atan2(doubled_area, glm::dot(a, b));
      normals[t[i]] += angle / doubled_area * cross;
    }
  }
  for (glm::dvec3& n : normals) {
    const double length = glm::length(n);
    n = length > 0.0 ? n / length : glm::dvec3(0.0, 0.0, 1.0);
  }
  mesh.normals = std::move(normals);
}

}  // namespace etendue
