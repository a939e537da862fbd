#pragma once
/// Improves a finished tree by moving subtrees to better places [Bittner2013], searched in parallel [Meister2018].

#include "compile/bvh.h"

namespace etendue {

struct ReinsertionConfig {
  std::uint32_t large = 512;          ///< nodes with the largest boxes, which are moved one after the other, and
  std::uint32_t large_passes = 8;     ///< how often, unless no move pays before
  std::uint32_t rounds = 6;           ///< of many moves that are found side by side
  float share = 0.01f;                ///< of the nodes a round tries to move: those with the largest boxes,
  std::uint32_t at_least = 1u << 13;  ///< but so many in small trees
  std::uint32_t max_depth = 96;       ///< of the tree: moves that would exceed it are not made
};

/// Lowers the sum of the boxes' areas, which binned splitting leaves far too large where large primitives lie around a
/// fine mesh. Siblings stay neighbours, but nodes no longer lie depth first. The same bytes for any number of threads.
void reinsert_subtrees(Bvh& bvh, const ReinsertionConfig& config = {});

}  // namespace etendue
