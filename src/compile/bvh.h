#pragma once
/// Binary bounding volume hierarchy by binned surface-area heuristic [Wald2007].

#include <cstdint>
#include <vector>

#include "compile/box.h"

namespace etendue {

struct BvhConfig {
  std::uint32_t max_leaf = 4;       ///< primitives in a leaf at most
  std::uint32_t bins = 32;          ///< candidate planes per axis, plus one
  float traversal_cost = 1.0f;      ///< of a node, in units of a primitive test
  std::uint32_t median_depth = 40;  ///< below this depth nodes are split into halves, which bounds the depth
};

/// Inner node (count 0): children at `first` and `first + 1`. Leaf: `count` entries of the order from `first`.
struct BvhBuildNode {
  Box box;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

struct Bvh {
  std::vector<BvhBuildNode> nodes;   ///< nodes[0] is the root; children follow their parent
  std::vector<std::uint32_t> order;  ///< primitive indices in leaf order
  std::uint32_t depth = 0;           ///< inner levels
};

/// The same bytes for any number of threads. `boxes` must not be empty.
Bvh build_bvh(const std::vector<Box>& boxes, const BvhConfig& config = {});

}  // namespace etendue
