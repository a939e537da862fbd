#pragma once
/// Choosing among many lights by their possible contribution to a point; docs/conventions.md, "Light tree".

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "reference/vec.h"

namespace etendue::reference {

/// One primitive that emits.
struct LightLeaf {
  std::uint32_t light = 0;      ///< the caller's number for the light
  std::uint32_t primitive = 0;  ///< within the light
  double power = 0.0;           ///< luminance times area, for a sphere times π r²; > 0
  Vec3 lower{0.0}, upper{0.0};  ///< box
  Vec3 normal{0.0};             ///< direction of emission; 0: all directions
  double cos_cone = 1.0;        ///< for a whole mesh, of the half angle of the cone of normals around `normal`
  /// The vertex normals of a triangle, or empty if it has none: it emits to their sides and those in between.
  std::vector<Vec3> corner_normals;
};

/// The word that decides at a level of the tree beyond those of the light block.
std::uint32_t hashed_word(std::uint32_t level, std::uint32_t word_b);

class LightTree {
 public:
  LightTree() = default;
  explicit LightTree(std::vector<LightLeaf> leaves);

  bool empty() const { return nodes_.empty(); }

  struct Choice {
    const LightLeaf* leaf = nullptr;  ///< null: nothing can contribute
    double prob = 0.0;
  };
  /// Chooses a leaf for a surface at `p` with shading normal `n`.
  Choice choose(const Vec3& p, const Vec3& n, std::uint32_t word_a, std::uint32_t word_b) const;
  /// The probability of choosing a primitive; 0 if it is not in the tree.
  double prob(const Vec3& p, const Vec3& n, std::uint32_t light, std::uint32_t primitive) const;

 private:
  struct Node {
    Vec3 center{0.0};
    double radius = 0.0;
    Vec3 axis{0.0};  ///< of the cone of normals
    double cos_cone = 1.0;
    double power = 0.0;
    std::uint32_t left = 0, right = 0;  ///< children; equal for a leaf
    std::uint32_t leaf = 0;             ///< first of its leaves
    std::uint32_t count = 0;            ///< number of its leaves
  };
  struct Key;
  std::uint32_t build(std::uint32_t first, std::uint32_t count, std::uint32_t level, std::vector<Key>& keys);
  Node bound(std::uint32_t first, std::uint32_t count) const;
  static double importance(const Node& node, const Vec3& p, const Vec3& n);
  /// Probability of the left child.
  double left_share(const Node& node, const Vec3& p, const Vec3& n) const;

  std::vector<LightLeaf> leaves_;                                            ///< in the order of the tree
  std::vector<Node> nodes_;                                                  ///< the root first
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> places_;  ///< (light, primitive) → index of its leaf
};

}  // namespace etendue::reference
