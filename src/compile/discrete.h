#pragma once
/// Discrete distributions with integer thresholds: docs/conventions.md, "Discrete choices".

#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

/// T(0), …, T(n) of the conventions for non-negative `weights`; empty when they are all zero. T(n) = 2^32.
std::vector<std::uint64_t> integer_thresholds(std::span<const double> weights);

}  // namespace etendue
