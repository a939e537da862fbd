#pragma once
/// Discrete distributions; docs/conventions.md, "Discrete choices".

#include <cstddef>
#include <cstdint>
#include <vector>

namespace etendue::reference {

/// Chooses an index in proportion to weights by comparing a whole 32-bit word with integer thresholds, so that all
/// renderers make the same choice.
class DiscreteChoice {
 public:
  /// There are fewer than 2^32 weights, finite and >= 0. The choice is empty if all of them are 0.
  explicit DiscreteChoice(const std::vector<double>& weights);
  DiscreteChoice() = default;

  bool empty() const { return thresholds_.empty(); }
  std::size_t choose(std::uint32_t word) const;  ///< must not be empty
  double prob(std::size_t index) const;          ///< 0 if empty
  /// T(0) … T(n); empty if there is nothing to choose.
  const std::vector<std::uint64_t>& thresholds() const { return thresholds_; }

 private:
  std::vector<std::uint64_t> thresholds_;
};

}  // namespace etendue::reference
