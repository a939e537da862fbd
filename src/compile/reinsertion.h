#pragma once
/// Improves a finished tree by moving subtrees to better places [Bittner2013], which are searched in parallel
/// [Meister2018].

#include "compile/bvh.h"

namespace etendue {

struct ReinsertionConfig {
  std::uint32_t large = 512;       ///< so many nodes with the largest boxes are moved one after the other,
  std::uint32_t large_passes = 8;  ///< in at most so many passes
  std::uint32_t rounds = 6;        ///< rounds of many moves found in parallel
  float share = 0.01f;             ///< fraction of the nodes that a round tries to move, those with the largest boxes,
  std::uint32_t at_least = 1u << 13;  ///< but at least so many
  std::uint32_t max_depth = 96;       ///< of the tree; moves that would exceed it are not made
};

/// Reduces the sum of the boxes' areas, which binned splitting leaves far too large if large primitives surround a fine
/// mesh. Siblings stay neighbours, but nodes are no longer in depth-first order. The result is the same, byte for byte,
/// for any number of threads.
void reinsert_subtrees(Bvh& bvh, const ReinsertionConfig& config = {});

}  // namespace etendue
