#pragma once
/// A mesh with several instances: its tree in object space, and the placement of that space by an instance.

#include <cstdint>
#include <vector>

#include "compile/bvh.h"
#include "compile/light_tree.h"
#include "compile/normalization.h"
#include "gpu_types.h"
#include "scene/bounds.h"
#include "scene/scene.h"

namespace etendue {

/// A mesh as a light, in object space: docs/conventions.md, "Shared meshes".
struct MeshLight {
  std::vector<double> areas;  ///< of the triangles; 0 for degenerate ones
  double area = 0.0;          ///< their sum
  glm::dmat3 spread{0.0};     ///< sum over triangles of area times n nᵀ, n the unit geometric normal
  glm::dvec3 axis{0.0};       ///< of the cone of normals; 0 if the mesh emits in all directions
  double cos_cone = -1.0;
};

/// A mesh prepared for the device: coordinates of object space scaled into [−1, 1].
struct SharedMesh {
  Normalization normalization;                ///< object space → [−1, 1]³
  std::vector<gpu::Primitive> primitives;     ///< triangles in the order of the mesh
  Bvh bvh;                                    ///< empty if no ray can hit any of them
  Bounds bounds;                              ///< in object space
  std::vector<Box> parts;                     ///< boxes that together contain the primitives
  std::uint32_t first_triangle = gpu::kNone;  ///< into the compiled vertex normals
  std::uint32_t first_light_primitive = gpu::kNone, light_primitive_count = 0;
  MeshLight light;  ///< filled in for meshes that emit somewhere
};

/// `shape` is a mesh.
SharedMesh prepare_shared_mesh(const Shape& shape);
/// The same without a tree and its parts: what its lights need.
SharedMesh prepare_shared_primitives(const Shape& shape);
MeshLight measure_mesh_light(const TriangleMesh& mesh);

/// The leaf of the light tree for a mesh placed by an instance, with the power for radiance 1. `area` is not set.
LightLeaf placed_light_leaf(const SharedMesh& mesh, const Instance& instance);
/// The area used as the weight of an instance: that of the transformed mesh, or slightly more if the axes are scaled
/// unevenly.
double placed_area(const MeshLight& light, const Instance& instance);

/// The map from the mesh's normalised object space to the normalised world, with bounds on the rounding errors of rays.
gpu::Place make_place(const SharedMesh& mesh, const Instance& instance, const Normalization& world);
/// Bounds of the instance in normalised world coordinates, widened by the rounding errors of a ray in the mesh's space.
Box placed_box(const SharedMesh& mesh, const gpu::Place& place);

}  // namespace etendue
