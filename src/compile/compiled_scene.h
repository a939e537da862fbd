#pragma once
/// Scene → vectors of GPU-ready structs.

#include <cstdint>
#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// Everything a device needs to render a scene, in the layouts of shaders/gpu_types.h. Positions are normalised:
/// translated and scaled by a power of two, so that single precision serves scenes of any size and place alike.
struct CompiledScene {
  gpu::Frame frame{};
  std::vector<gpu::uvec4> records;  ///< the few primitives outside the tree, then the tree: nodes and primitives
  std::vector<gpu::Shape> shapes;
  std::vector<gpu::uvec4> triangles;  ///< vertex indices of meshes with normals, xyz
  std::vector<gpu::vec4> normals;     ///< vertex normals, xyz
  std::vector<gpu::LightShape> light_shapes;
  std::vector<gpu::LightPrimitive> light_primitives;
  std::vector<gpu::LightPair> light_pairs;  ///< of the light tree; empty where lights are chosen by power
  /// Per shape in `turns` the place in this table of its first primitive's trail, then the trails.
  std::vector<gpu::LightTrail> light_trails;
  std::uint32_t light_tree_depth = 0;    ///< levels below the root; 0 where there is no tree
  std::vector<float> filter_knots;       ///< kFilterSteps + 1 offsets in pixels; empty for the box filter
  std::uint32_t tree_root = gpu::kNone;  ///< slot of the root; kNone when all primitives stand outside the tree
  std::uint32_t tree_depth = 0;          ///< levels of nodes
  bool has_spheres = false;
  std::uint32_t few_triangles = 0;  ///< the first primitives stand outside the tree, see kFewPrimitives
  std::uint32_t few_spheres = 0;    ///< after the triangles
};

CompiledScene compile_scene(const Scene& scene);

}  // namespace etendue
