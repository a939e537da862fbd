#include "compile/discrete.h"

#include <algorithm>
#include <cmath>

namespace etendue {

std::vector<std::uint64_t> integer_thresholds(std::span<const double> weights) {
  constexpr std::uint64_t kOne = std::uint64_t{1} << 32;
  double total = 0.0;
  for (const double w : weights) total += w;
  if (!(total > 0.0)) return {};
  const std::size_t n = weights.size();
  std::vector<std::uint64_t> thresholds(n + 1, 0);
  double prefix = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    prefix += weights[i];
    const auto exact = static_cast<std::uint64_t>(std::floor(prefix / total * 0x1p32));
    thresholds[i + 1] = std::max({exact, thresholds[i] + (weights[i] > 0.0 ? 1u : 0u)});
  }
  thresholds[n] = kOne;
  for (std::size_t i = n; i-- > 0;) {
    thresholds[i] = std::min(thresholds[i], thresholds[i + 1] - (weights[i] > 0.0 ? 1u : 0u));
  }
  thresholds[0] = 0;
  return thresholds;
}

SearchTree::SearchTree(std::uint32_t count) {
  for (std::uint64_t span = 1; span < count; ++levels) {
    span *= gpu::kSearchFan;
    nodes += static_cast<std::uint32_t>((count + span - 1) / span);
  }
}

void write_search_tree(std::span<const std::uint64_t> thresholds, std::span<gpu::uvec4> nodes) {
  constexpr std::uint64_t kLargest = 0xffffffff;
  const std::size_t count = thresholds.size();
  std::size_t range = 1, node = 0;  // number of entries in one branch
  while (range * gpu::kSearchFan < count) range *= gpu::kSearchFan;
  for (; range > 0 && count > 1; range /= gpu::kSearchFan) {
    for (std::size_t first = 0; first < count; first += range * gpu::kSearchFan, ++node) {
      for (gpu::uint branch = 1; branch < gpu::kSearchFan; ++branch) {
        const std::size_t entry = first + branch * range;
        const std::uint64_t threshold = entry < count ? std::min(thresholds[entry], kLargest) : kLargest;
        nodes[node][static_cast<int>(branch - 1)] = static_cast<gpu::uint>(threshold);
      }
    }
  }
}

}  // namespace etendue
