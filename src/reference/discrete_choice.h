#pragma once
/// Choice among weights; docs/conventions.md, "Discrete choices".

#include <cstddef>
#include <cstdint>
#include <vector>

namespace etendue::reference {

/// Chooses an index in proportion to weights by comparing a whole 32-bit word with integer thresholds, so that every
/// renderer chooses the same.
class DiscreteChoice {
 public:
  /// Weights are finite and >= 0, fewer than 2^32. Empty when all of them are 0.
  explicit DiscreteChoice(const std::vector<double>& weights);
  DiscreteChoice() = default;

  bool empty() const { return thresholds_.empty(); }
  std::size_t choose(std::uint32_t word) const;  ///< not when empty
  double prob(std::size_t index) const;          ///< 0 when empty
  /// T(0) … T(n); empty when there is nothing to choose.
  const std::vector<std::uint64_t>& thresholds() const { return thresholds_; }

 private:
  std::vector<std::uint64_t> thresholds_;
};

}  // namespace etendue::reference
