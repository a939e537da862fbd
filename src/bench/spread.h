#pragma once
/// Repeated measurements of one quantity.

#include <cstddef>
#include <vector>

namespace etendue {

struct Spread {
  double median = 0, min = 0, max = 0;
  std::size_t count = 0;  ///< 0: nothing was measured
};

Spread spread_of(std::vector<double> values);

}  // namespace etendue
