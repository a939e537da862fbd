#pragma once
/// The tree that chooses among many lights: docs/conventions.md, "Light tree".

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "compile/normalization.h"
#include "gpu_types.h"

namespace etendue {

/// A primitive that emits, in world space.
struct LightLeaf {
  double power = 0.0;     ///< luminance · area, for a sphere luminance · πr²; > 0
  double area = 0.0;      ///< of the primitive
  glm::dvec3 lower{0.0};  ///< corners of its box
  glm::dvec3 upper{0.0};
  glm::dvec3 normal{0.0};  ///< unit; 0 if it emits in all directions, as a sphere does
  /// The vertex normals of a triangle, or empty if it has none: it emits on the sides of these and of all normals in
  /// between.
  std::vector<glm::dvec3> corner_normals;
  /// For a leaf that is a whole mesh: cosine of the half angle of the cone of normals around `normal`.
  double cos_cone = 1.0;
  std::uint32_t light_primitive = 0;  ///< combined with kLightLeaf in a pair
};

struct FlatLightTree {
  std::vector<gpu::LightPair> pairs;    ///< the root's pair comes first
  std::vector<gpu::LightTrail> trails;  ///< of each leaf
  std::uint32_t depth = 0;              ///< levels below the root, at most kMaxLightTreeDepth
};

/// Builds the tree of at least two `leaves`, in the order of the scene. The bytes are the same on every machine,
/// because splits compare integers and sums are formed in order.
FlatLightTree build_light_tree(const std::vector<LightLeaf>& leaves, const Normalization& normalization);

}  // namespace etendue
