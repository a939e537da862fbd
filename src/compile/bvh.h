#pragma once
/// Binary bounding volume hierarchy, built with the binned surface-area heuristic [Wald2007], with one primitive per
/// leaf.

#include <cstdint>
#include <vector>

#include "compile/box.h"

namespace etendue {

struct BvhConfig {
  std::uint32_t bins = 32;          ///< candidate planes per axis, plus one; at most 64
  std::uint32_t median_depth = 40;  ///< below this depth nodes are split into halves, which bounds the depth
};

/// A leaf holds primitive `first`; an inner node has its children at `first` and `first + 1`.
struct BvhNode {
  Box box;
  std::uint32_t first = 0;
  std::uint32_t leaf = 0;  ///< 1 for a leaf
};

/// nodes[0] is the root; n primitives make 2n − 1 nodes. Siblings are neighbours: an odd index and the even one after
/// it.
struct Bvh {
  std::vector<BvhNode> nodes;
};

/// The sibling of a node other than the root.
constexpr std::uint32_t bvh_sibling(std::uint32_t node) {
  return ((node - 1) ^ 1u) + 1;
}

/// Builds a tree of all boxes except those in `without`, an ascending list; at least one must be left. The result is
/// the same, byte for byte, for any number of threads. Nodes are in depth-first order.
Bvh build_bvh(std::vector<Box> boxes, const std::vector<std::uint32_t>& without = {}, const BvhConfig& config = {});

}  // namespace etendue
