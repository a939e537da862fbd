#include "bench/spread.h"

#include <algorithm>

namespace etendue {

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return {
      .median = 0.5 * (values[(n - 1) / 2] + values[n / 2]), .min = values.front(), .max = values.back(), .count = n};
}

}  // namespace etendue
