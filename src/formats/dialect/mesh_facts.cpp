#include "formats/dialect/mesh_facts.h"

#include "formats/mesh/mesh_content.h"

namespace etendue {

void apply_mesh_facts(const MeshFacts& facts, bool states_v, TriangleMesh& mesh) {
  if (facts.smooth_without_normals && mesh.normals.empty()) make_smooth_normals(mesh);
  if (states_v || facts.v_origin == VOrigin::bottom) return;
  for (std::vector<glm::vec2>& set : mesh.uv_sets) {
    for (glm::vec2& uv : set) uv.y = 1.0f - uv.y;
  }
}

}  // namespace etendue
