#include "formats/dialect/mesh_facts.h"

#include <cmath>

namespace etendue {

void make_smooth_normals(TriangleMesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), glm::dvec3(0.0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 p[3] = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
    const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double doubled_area = glm::length(cross);
    if (!(doubled_area > 0.0)) continue;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 a = p[(i + 1) % 3] - p[i], b = p[(i + 2) % 3] - p[i];
      const double angle = std::atan2(doubled_area, glm::dot(a, b));
      mesh.normals[t[i]] += angle / doubled_area * cross;
    }
  }
  for (glm::dvec3& n : mesh.normals) {
    const double length = glm::length(n);
    n = length > 0.0 ? n / length : glm::dvec3(0.0, 0.0, 1.0);
  }
}

void apply_mesh_facts(const MeshFacts& facts, bool states_v, TriangleMesh& mesh) {
  if (facts.smooth_without_normals && mesh.normals.empty()) make_smooth_normals(mesh);
  if (states_v || facts.v_origin == VOrigin::bottom) return;
  for (std::vector<glm::vec2>& set : mesh.uv_sets) {
    for (glm::vec2& uv : set) uv.y = 1.0f - uv.y;
  }
}

}  // namespace etendue
