#pragma once
/// Everything that the adapters of a surface may decide about a ray, with its probability.

#include <optional>
#include <utility>
#include <vector>

#include "reference/adapters.h"

namespace etendue::reference {

/// What the adapters that choose by chance have decided, and what the ray meets then.
struct Outcome {
  double probability = 0.0;
  std::vector<std::pair<std::uint32_t, bool>> decisions;  ///< rows of the table, and whether their events happened
  std::optional<ChosenMaterials> materials;               ///< nothing if the ray passes
};

class Outcomes {
 public:
  static constexpr std::size_t kMost = 4096;
  /// For a ray in direction `d`. Impossible outcomes are left out, and so is everything beyond the first kMost ones.
  Outcomes(const Scene& scene, const Surface& surface, const Vec3& d);

  const std::vector<Outcome>& all() const { return outcomes_; }
  bool complete() const { return complete_; }
  /// The number of the outcome that a decider arrives at.
  std::size_t of(Decider& decider) const;

 private:
  /// A decision, or, with the row kOutcome, the number of an outcome in `happens`.
  struct Node {
    std::uint32_t row;
    double probability;
    std::size_t happens, otherwise;
  };
  std::size_t explore(const Scene& scene, const Surface& surface, const Vec3& d, Outcome prefix);

  std::vector<Outcome> outcomes_;
  std::vector<Node> nodes_;
  std::size_t root_ = 0;
  bool complete_ = true;
};

}  // namespace etendue::reference
