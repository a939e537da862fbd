#include "reference/discrete_choice.h"

#include <algorithm>
#include <cmath>

namespace etendue::reference {

DiscreteChoice::DiscreteChoice(const std::vector<double>& weights) {
  double sum = 0.0;
  for (const double weight : weights) sum += weight;
  if (!(sum > 0.0)) return;
  const std::size_t n = weights.size();
  thresholds_.assign(n + 1, 0);
  double prefix = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    prefix += weights[i];
    thresholds_[i + 1] = static_cast<std::uint64_t>(std::floor(0x1p32 * prefix / sum));
  }
  // Every entry with a positive weight gets at least one unit: first in ascending order, then in descending order, so
  // that the sum is 2^32 again.
  for (std::size_t i = 0; i < n; ++i)
    thresholds_[i + 1] = std::max(thresholds_[i + 1], thresholds_[i] + (weights[i] > 0.0 ? 1 : 0));
  thresholds_[n] = std::uint64_t{1} << 32;
  for (std::size_t i = n; i-- > 0;)
    thresholds_[i] = std::min(thresholds_[i], thresholds_[i + 1] - (weights[i] > 0.0 ? 1 : 0));
}

std::size_t DiscreteChoice::choose(std::uint32_t word) const {
  const auto above = std::upper_bound(thresholds_.begin(), thresholds_.end(), std::uint64_t{word});
  return static_cast<std::size_t>(above - thresholds_.begin()) - 1;
}

double DiscreteChoice::prob(std::size_t index) const {
  return empty() ? 0.0 : static_cast<double>(thresholds_[index + 1] - thresholds_[index]) * 0x1p-32;
}

}  // namespace etendue::reference
