#pragma once
/// Applies a dialect's conventions to meshes whose files leave them open.

#include "formats/dialect/dialect.h"
#include "scene/scene.h"

namespace etendue {

/// Computes smooth normals if the mesh has none and the dialect wants them, and makes v grow upward unless `states_v`.
void apply_mesh_facts(const MeshFacts& facts, bool states_v, TriangleMesh& mesh);

}  // namespace etendue
