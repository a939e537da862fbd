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
  double power = 0.0;     ///< luminance · area, of a sphere luminance · πr²; > 0
  double area = 0.0;      ///< of the primitive
  glm::dvec3 lower{0.0};  ///< corners of its box
  glm::dvec3 upper{0.0};
  glm::dvec3 normal{0.0};  ///< unit; 0 where it shines to all sides, as a sphere does
  /// Of a triangle with vertex normals: it shines where any of them, or one in between, does. Else empty.
  std::vector<glm::dvec3> corner_normals;
  /// Of a leaf that is a whole mesh: cosine of the half angle of the cone of normals around `normal`.
  double cos_cone = 1.0;
  std::uint32_t light_primitive = 0;  ///< what a pair holds beside kLightLeaf
};

struct FlatLightTree {
  std::vector<gpu::LightPair> pairs;    ///< the root's first
  std::vector<gpu::LightTrail> trails;  ///< of each leaf
  std::uint32_t depth = 0;              ///< levels below the root, at most kMaxLightTreeDepth
};

/// Bytes are the same on every machine: splits compare integers, sums run in order. At least two `leaves`, in the order
/// of the scene.
FlatLightTree build_light_tree(const std::vector<LightLeaf>& leaves, const Normalization& normalization);

}  // namespace etendue
