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

}  // namespace etendue
