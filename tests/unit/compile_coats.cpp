/// Coats of roughplastic: the tables against integrals of other variables with many more nodes.

#include <array>

#include <gtest/gtest.h>

#include "compile/coats.h"

namespace etendue {
namespace {

/// Values of the midpoint rule with 6000 × 3000 nodes, even in the cube root of the slopes' distribution; nodes of the
/// table 2, 10, 31 and 63. Those of the reference are tested against the same numbers.
struct Known {
  Roughness::Distribution distribution;
  double alpha, eta;
  std::array<double, 4> passed;
  double inside;
};
constexpr Known kKnown[] = {
    {Roughness::Distribution::beckmann, 0.3, 1.49, {0.6961288, 0.7637606, 0.9006481, 0.9610480}, 0.523681},
    {Roughness::Distribution::ggx, 0.1, 1.49, {0.5708589, 0.6728858, 0.9054720, 0.9604783}, 0.545796},
    {Roughness::Distribution::ggx, 0.6, 1.8, {0.5167875, 0.6112165, 0.7707315, 0.8849941}, 0.350218}};

TEST(CompileCoats, AreExact) {
  constexpr std::array<std::size_t, 4> kNodes{2, 10, 31, 63};
  for (const Known& known : kKnown) {
    const RoughCoat coat = rough_coat({known.distribution, known.alpha, known.alpha}, known.eta);
    for (std::size_t i = 0; i < kNodes.size(); ++i)
      EXPECT_NEAR(coat.transmittances[kNodes[i]], known.passed[i], 1e-6) << known.alpha << ' ' << kNodes[i];
    EXPECT_NEAR(coat.reflectance_inside, known.inside, 3e-6) << known.alpha;
  }
}

}  // namespace
}  // namespace etendue
