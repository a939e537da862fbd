#pragma once
/// What a dialect says about meshes whose files leave it open.

#include "formats/dialect/dialect.h"
#include "scene/scene.h"

namespace etendue {

/// Makes smooth normals where the mesh has none and the dialect wants them, and turns v upward unless `states_v`.
void apply_mesh_facts(const MeshFacts& facts, bool states_v, TriangleMesh& mesh);

}  // namespace etendue
