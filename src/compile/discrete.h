#pragma once
/// Discrete distributions with integer thresholds: docs/conventions.md, "Discrete choices".

#include <cstdint>
#include <span>
#include <vector>

#include "gpu_types.h"

namespace etendue {

/// T(0), …, T(n) of the conventions for non-negative `weights`, with T(n) = 2^32; empty if all weights are zero.
std::vector<std::uint64_t> integer_thresholds(std::span<const double> weights);

/// The choice of one of `count` entries, as a tree with gpu::kSearchFan branches per node.
struct SearchTree {
  std::uint32_t levels = 0;  ///< the least number with kSearchFan^levels >= count
  std::uint32_t nodes = 0;   ///< of all levels
  explicit SearchTree(std::uint32_t count);
};

/// Writes the nodes for T(0), …, T(count − 1).
void write_search_tree(std::span<const std::uint64_t> thresholds, std::span<gpu::uvec4> nodes);

}  // namespace etendue
