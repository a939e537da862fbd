#pragma once
/// A compiled scene in the form needed for the driver's acceleration structures: the host's counterpart of
/// shaders/trace_query.glsl.

#include <cstdint>
#include <vector>

#include "compile/box.h"
#include "compile/compiled_scene.h"

namespace etendue {

/// Consecutive primitives: those of the world, or of a shared mesh.
struct QueryMesh {
  std::uint32_t first = 0;  ///< index of its first record
  std::uint32_t count = 0;
  /// Boxes are widened by this on all sides: the distance by which rounding may move a ray, in this mesh's space.
  float slack = 0.0f;
};

/// An instance of a mesh, for the driver.
struct QueryInstance {
  std::uint32_t mesh = 0;
  std::uint32_t name = gpu::kQueryWorld;
  float world_from_mesh[3][4]{};  ///< rows
};

struct QueryScene {
  PageVector<gpu::uvec4> records;  ///< replace those of the tree, see gpu::kQueryWorld
  std::uint32_t instances_at = 0;  ///< slot of the first instance's record, or where it would be without instances
  std::vector<QueryMesh> meshes;   ///< none of them is empty
  std::vector<QueryInstance> instances;
};

/// For a scene without a tree, the result contains only the few primitives. Throws Error(lost) if there are more
/// instances than a driver can distinguish.
QueryScene query_scene(const CompiledScene& scene);

/// The boxes of the mesh's primitives, in their order.
std::vector<Box> query_boxes(const QueryScene& scene, const QueryMesh& mesh);

}  // namespace etendue
