#pragma once
/// A compiled scene as a driver's acceleration structures take it: the host's side of shaders/trace_query.glsl.

#include <cstdint>
#include <vector>

#include "compile/box.h"
#include "compile/compiled_scene.h"

namespace etendue {

/// Primitives that lie beside each other: those of the world, or of a shared mesh.
struct QueryMesh {
  std::uint32_t first = 0;  ///< number of its first record
  std::uint32_t count = 0;
  /// Boxes are larger by this on all sides: what rounding may move a ray by, against them, in this mesh's space.
  float slack = 0.0f;
};

/// Where the driver meets a mesh.
struct QueryInstance {
  std::uint32_t mesh = 0;
  std::uint32_t name = gpu::kQueryWorld;
  float world_from_mesh[3][4]{};  ///< rows
};

struct QueryScene {
  std::vector<gpu::uvec4> records;  ///< in place of the tree's, see gpu::kQueryWorld
  std::uint32_t instances_at = 0;   ///< slot of the first instance's record, or where it would be
  std::vector<QueryMesh> meshes;    ///< none of them is empty
  std::vector<QueryInstance> instances;
};

/// Of a scene without a tree nothing but the few primitives. Throws Error(lost) for more instances than a driver can
/// tell apart.
QueryScene query_scene(const CompiledScene& scene);

/// Of the mesh's primitives, in their order.
std::vector<Box> query_boxes(const QueryScene& scene, const QueryMesh& mesh);

}  // namespace etendue
