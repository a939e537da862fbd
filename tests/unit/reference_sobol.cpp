// Sobol sets: the points are nets, scrambling keeps them so and makes them uniform, and sets are independent of each
// other.

#include <array>
#include <cmath>
#include <functional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "reference/rng.h"

namespace etendue::reference {
namespace {

// True when every elementary interval 2^-i × 2^-(bits - i) holds exactly one of the 2^bits points: a (0, bits, 2)-net
// in base 2.
bool is_net(const std::vector<std::array<std::uint32_t, 2>>& points, unsigned bits) {
  for (unsigned i = 0; i <= bits; ++i) {
    std::set<std::pair<std::uint64_t, std::uint64_t>> cells;
    for (const auto& [x, y] : points) cells.insert({std::uint64_t{x} << i >> 32, std::uint64_t{y} << (bits - i) >> 32});
    if (cells.size() != points.size()) return false;
  }
  return true;
}

// The words of a whole set in a block.
std::vector<Words> words_of_set(std::uint32_t pixel, std::uint32_t set, std::uint32_t block, std::uint32_t bits) {
  std::vector<Words> words;
  for (std::uint32_t i = 0; i < 1u << bits; ++i)
    words.push_back(SampleRandom(9, pixel, (set << bits) + i, bits).block(block));
  return words;
}

TEST(ReferenceSobol, FirstPoints) {
  // The first eight points of [Joe2008], dimensions 1 to 4, in eighths; index 0 is the origin.
  const std::array<std::array<std::uint32_t, 4>, 8> expected = {
      {{0, 0, 0, 0}, {4, 4, 4, 4}, {2, 6, 6, 6}, {6, 2, 2, 2}, {1, 5, 3, 1}, {5, 1, 7, 5}, {3, 3, 5, 7}, {7, 7, 1, 3}}};
  for (std::uint32_t i = 0; i < 8; ++i) {
    for (unsigned d = 0; d < 4; ++d)
      EXPECT_EQ(sobol(i, d) >> 29, expected[i][d]) << "point " << i << ", dimension " << d + 1;
  }
}

TEST(ReferenceSobol, EveryAlignedBlockOfTheFirstTwoDimensionsIsANet) {
  for (unsigned bits = 0; bits <= 10; ++bits) {
    for (const std::uint32_t block : {0u, 1u, 5u, 1023u}) {
      std::vector<std::array<std::uint32_t, 2>> points;
      for (std::uint32_t i = 0; i < 1u << bits; ++i)
        points.push_back({sobol((block << bits) + i, 0), sobol((block << bits) + i, 1)});
      EXPECT_TRUE(is_net(points, bits)) << "2^" << bits << " points, block " << block;
    }
  }
}

TEST(ReferenceSobol, ScramblingKeepsNetsWhereTwoNumbersMakeAPoint) {
  // Film position, point on a light, direction: the pairs of docs/conventions.md.
  struct Pair {
    std::uint32_t block;
    int x, y;
  };
  for (const Pair pair : {Pair{0, 0, 1}, {1, 2, 3}, {7, 2, 3}, {2, 1, 2}, {6, 1, 2}}) {
    for (std::uint32_t bits = 1; bits <= 8; ++bits) {
      std::vector<std::array<std::uint32_t, 2>> points;
      for (const Words& w : words_of_set(3, bits, pair.block, bits)) points.push_back({w[pair.x], w[pair.y]});
      EXPECT_TRUE(is_net(points, bits)) << "block " << pair.block << ", 2^" << bits << " points";
    }
  }
}

TEST(ReferenceSobol, EveryNumberIsStratified) {
  for (std::uint32_t block = 0; block < 5; ++block) {
    for (int k = 0; k < 4; ++k) {
      std::set<std::uint32_t> strata;
      for (const Words& w : words_of_set(77, 2, block, 6)) strata.insert(w[k] >> 26);
      EXPECT_EQ(strata.size(), 64u) << "block " << block << ", word " << k;
    }
  }
}

// z-score of chi² for equal expectations.
double chi2_score(const std::vector<double>& counts) {
  double total = 0.0, sum = 0.0;
  for (const double c : counts) total += c;
  const double expected = total / static_cast<double>(counts.size());
  for (const double c : counts) sum += (c - expected) * (c - expected) / expected;
  const double dof = static_cast<double>(counts.size()) - 1.0;
  return (sum - dof) / std::sqrt(2.0 * dof);
}

TEST(ReferenceSobol, OnePointOfEachSetIsUniform) {
  // Over sets a point is anywhere with equal chance: in one number, and in two numbers of one or of two blocks.
  const std::uint32_t path = 5;  // within its set
  std::vector<double> top(256, 0.0), low(256, 0.0), pair(256, 0.0), blocks(256, 0.0);
  for (std::uint32_t set = 0; set < 100000; ++set) {
    const SampleRandom random(1, 4, (set << 4) + path, 4);
    const Words camera = random.block(0), bsdf = random.block(2);
    ++top[camera[0] >> 24];
    ++low[camera[0] >> 12 & 255u];
    ++pair[(camera[0] >> 28) * 16 + (camera[1] >> 28)];
    ++blocks[(camera[0] >> 28) * 16 + (bsdf[1] >> 28)];
  }
  for (const auto& counts : {top, low, pair, blocks}) EXPECT_LT(std::abs(chi2_score(counts)), 4.5);
}

double unit(std::uint32_t word) {
  return (word + 0.5) * 0x1p-32;
}

// Mean and variance, over sets, of the mean of an integrand over a set.
struct SetStatistics {
  double mean = 0.0, variance = 0.0;
};
SetStatistics set_statistics(std::uint32_t bits, int sets, const std::function<double(const SampleRandom&)>& f) {
  double sum = 0.0, squares = 0.0;
  for (int s = 0; s < sets; ++s) {
    double mean = 0.0;
    for (std::uint32_t i = 0; i < 1u << bits; ++i)
      mean +=
          f(SampleRandom(2, 11, (static_cast<std::uint32_t>(s) << bits) + i, bits)) / static_cast<double>(1u << bits);
    sum += mean;
    squares += mean * mean;
  }
  const double mean = sum / sets;
  return {mean, (squares - sets * mean * mean) / (sets - 1)};
}

TEST(ReferenceSobol, ConvergesFasterThanIndependentNumbersOnASmoothIntegrand) {
  const auto f = [](const SampleRandom& random) {
    const Words w = random.block(0);
    return std::exp(-unit(w[0]) - 2.0 * unit(w[1]));
  };
  const double expected = (1.0 - std::exp(-1.0)) * (1.0 - std::exp(-2.0)) / 2.0;
  const double second = (1.0 - std::exp(-2.0)) / 2.0 * (1.0 - std::exp(-4.0)) / 4.0;
  const double independent = second - expected * expected;  // variance of one sample
  double previous = independent;
  for (std::uint32_t bits = 2; bits <= 8; bits += 2) {
    const SetStatistics s = set_statistics(bits, 2000, f);
    EXPECT_NEAR(s.mean, expected, 5.0 * std::sqrt(s.variance / 2000)) << "2^" << bits << " points";
    // Four times the points: independent numbers would give a quarter of the variance, scrambled nets almost 1/64
    // [Owen1997].
    EXPECT_LT(s.variance, previous / 16.0) << "2^" << bits << " points";
    previous = s.variance;
  }
  EXPECT_LT(previous, independent / 256.0 / 1000.0);
}

TEST(ReferenceSobol, BlocksAreNoWorseThanIndependentTogether) {
  // A product of numbers of two blocks: padding must not tie them together.
  for (std::uint32_t bits = 2; bits <= 6; ++bits) {
    const SetStatistics s = set_statistics(bits, 4000, [](const SampleRandom& random) {
      return (unit(random.block(0)[0]) - 0.5) * (unit(random.block(2)[1]) - 0.5);
    });
    // Random orders of 2^bits strata; of independent numbers it would be 1 / 144 / 2^bits.
    const double expected = 1.0 / 144.0 / static_cast<double>((1u << bits) - 1);
    EXPECT_NEAR(s.mean, 0.0, 5.0 * std::sqrt(s.variance / 4000));
    EXPECT_NEAR(s.variance / expected, 1.0, 0.12) << "2^" << bits << " points";
  }
}

TEST(ReferenceSobol, TheErrorEstimatedOverSetsIsTheError) {
  // 16 sets of 16 points each: the mean over sets, in units of the standard error that the sets tell, has the variance
  // of Student's t.
  const auto f = [](const SampleRandom& random) {
    const Words w = random.block(2);
    return unit(w[1]) * unit(w[1]) + unit(w[2]) > 0.9 ? 1.0 : 0.0;
  };
  constexpr int kExperiments = 1500, kSets = 16;
  double mean_of_all = 0.0;
  std::vector<std::pair<double, double>> results;
  for (int e = 0; e < kExperiments; ++e) {
    double sum = 0.0, squares = 0.0;
    for (int s = 0; s < kSets; ++s) {
      double mean = 0.0;
      for (std::uint32_t i = 0; i < 16; ++i)
        mean += f(SampleRandom(5, static_cast<std::uint32_t>(e), static_cast<std::uint32_t>(s) * 16 + i, 4)) / 16.0;
      sum += mean;
      squares += mean * mean;
    }
    const double mean = sum / kSets;
    results.emplace_back(mean, (squares - kSets * mean * mean) / (kSets - 1) / kSets);
    mean_of_all += mean / kExperiments;
  }
  double claimed = 0.0, actual = 0.0;
  for (const auto& [mean, variance] : results) {
    claimed += variance / kExperiments;
    actual += (mean - mean_of_all) * (mean - mean_of_all) / (kExperiments - 1);
  }
  EXPECT_NEAR(actual / claimed, 1.0, 5.0 * std::sqrt(2.0 / kExperiments));
}

}  // namespace
}  // namespace etendue::reference
