#pragma once
/// What the adapters of a patch may choose for a direction of incidence, as the chi-square test looks at it.

#include <optional>
#include <vector>

#include "reference/outcomes.h"
#include "reference/ray.h"
#include "validate/sample_cells.h"

namespace etendue {

/// A material that is chosen, in one frame: its samples are counted on their own.
struct TestLeaf {
  reference::ChosenMaterial chosen;
  Bsdf bsdf;                                  ///< with the parameters that it has on the patch
  double probability = 0;                     ///< of all outcomes that choose it
  bool black = false;                         ///< scatters nothing toward wo
  std::optional<std::uint32_t> example = {};  ///< a sample that chooses it
  SampleCounts counts;
};

class TestLeaves {
 public:
  /// The samples that are examples are those of the stream `seed`. Throws Error(usage) if there are too many outcomes.
  TestLeaves(const Scene& patch, const glm::dvec3& wo, std::uint32_t resolution, std::uint32_t seed);

  const std::vector<TestLeaf>& leaves() const { return leaves_; }
  /// The probability that light passes, and the number of samples that did.
  double passing() const { return passing_; }
  double passed() const { return passed_; }
  /// Samples that did not, although they should have.
  double unforeseen() const { return unforeseen_; }
  /// There are adapters, so that something is chosen.
  bool adapted() const;
  /// The material that a sample should choose; nothing if light should pass.
  std::optional<std::size_t> leaf_of(std::uint32_t sample) const { return leaf_of_[outcome_of(sample)]; }
  /// Counts a sample of the stream.
  void add(const BsdfDraw& draw, std::uint32_t sample);

  /// Outcomes that differ only in the choice of the blend that mixes them: on average their mixtures have the density
  /// of what they choose.
  struct Pair {
    std::vector<std::size_t> outcomes;
    bool complete = true;  ///< there is an example of each
  };
  const std::vector<Pair>& pairs() const { return pairs_; }
  std::size_t pair_of(std::uint32_t sample) const { return pair_of_[outcome_of(sample)]; }
  double probability(std::size_t outcome) const { return outcomes_.all()[outcome].probability; }
  std::uint32_t example(std::size_t outcome) const { return *examples_[outcome]; }

 private:
  std::size_t outcome_of(std::uint32_t sample) const;
  void find_examples();
  void find_leaves(std::uint32_t resolution);
  void find_pairs();
  TestLeaf make_leaf(const reference::ChosenMaterial& chosen, std::uint32_t resolution) const;

  const Scene& patch_;
  glm::dvec3 wo_;
  std::uint32_t seed_;
  reference::Surface surface_;
  reference::Outcomes outcomes_;
  std::vector<std::optional<std::uint32_t>> examples_;  ///< of each outcome
  std::vector<std::optional<std::size_t>> leaf_of_;     ///< of each outcome; none if light passes
  std::vector<std::size_t> pair_of_;
  std::vector<TestLeaf> leaves_;
  std::vector<Pair> pairs_;
  double passing_ = 0, passed_ = 0, unforeseen_ = 0;
};

}  // namespace etendue
