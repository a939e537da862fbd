// Statistics against printed tables, independent identities and simulation with fixed seeds.

#include "validate/statistics.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/errors.h"

namespace etendue {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kNan = std::numeric_limits<double>::quiet_NaN();

// Bounds outside of which a count of rejections shows a wrong false-alarm rate; 1e-4 each side of the true rate.
void expect_rate(std::uint64_t rejected, std::uint64_t experiments, double rate) {
  EXPECT_GT(binomial_two_sided(rejected, experiments, rate), 1e-4)
      << rejected << " of " << experiments << " rejected where the rate should be " << rate;
}

TEST(Tails, NormalMatchesPrintedTable) {
  EXPECT_NEAR(normal_two_sided(1.959963984540054), 0.05, 1e-15);
  EXPECT_NEAR(normal_two_sided(2.5758293035489004), 0.01, 1e-15);
  EXPECT_NEAR(normal_upper_tail(0.0), 0.5, 1e-16);
  EXPECT_NEAR(normal_upper_tail(-1.6448536269514722), 0.95, 1e-15);
  EXPECT_EQ(normal_two_sided(0.0), 1.0);
  EXPECT_EQ(normal_two_sided(kInfinity), 0.0);
  EXPECT_EQ(normal_two_sided(kNan), 0.0);
}

TEST(Tails, NormalFarTailKeepsItsDigits) {
  // Asymptotic series phi(z)/z (1 − 1/z² + 3/z⁴ − 15/z⁶ + 105/z⁸): at z = 30 its error is below 1e-11 relative.
  const double z = 30.0, w = 1.0 / (z * z);
  const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
  const double series = density / z * (1.0 - w + 3.0 * w * w - 15.0 * w * w * w + 105.0 * w * w * w * w);
  EXPECT_NEAR(normal_upper_tail(z) / series, 1.0, 1e-10);
  EXPECT_GT(normal_upper_tail(z), 0.0);
  EXPECT_NEAR(normal_quantile_upper(normal_upper_tail(7.0)), 7.0, 1e-12);
}

TEST(Tails, StudentClosedForms) {
  // One degree of freedom is Cauchy: P(|T| > t) = 1 − 2/π atan t; two degrees: 1 − t/sqrt(t² + 2).
  for (double t : {0.1, 1.0, 12.706204736}) {
    EXPECT_NEAR(student_two_sided(t, 1), 1.0 - 2.0 / std::numbers::pi * std::atan(t), 1e-14);
    EXPECT_NEAR(student_two_sided(t, 2), 1.0 - t / std::sqrt(t * t + 2.0), 1e-14);
  }
  EXPECT_NEAR(student_two_sided(12.706204736, 1), 0.05, 1e-10);
  EXPECT_NEAR(student_two_sided(2.228138852, 10), 0.05, 1e-9);  // table
  EXPECT_NEAR(student_two_sided(3.169272667, 10), 0.01, 1e-9);  // table
  // Far tail of Cauchy: 2/π atan(1/t), which 1 − cdf would lose entirely.
  EXPECT_NEAR(student_two_sided(1e18, 1) / (2.0 / std::numbers::pi * 1e-18), 1.0, 1e-12);
  // Many degrees of freedom approach the normal, in the tail as well.
  EXPECT_NEAR(student_two_sided(20.0, 1e9) / normal_two_sided(20.0), 1.0, 1e-3);
  EXPECT_EQ(student_two_sided(kInfinity, 10), 0.0);
  EXPECT_EQ(student_two_sided(kNan, 10), 0.0);
}

TEST(Tails, ChiSquareClosedForms) {
  // Two degrees of freedom: exp(−x/2); one: the square of a normal.
  EXPECT_NEAR(chi_square_upper_tail(3.0, 2), std::exp(-1.5), 1e-15);
  EXPECT_NEAR(chi_square_upper_tail(700.0, 2) / std::exp(-350.0), 1.0, 1e-11);
  EXPECT_NEAR(chi_square_upper_tail(2.7 * 2.7, 1), normal_two_sided(2.7), 1e-15);
  EXPECT_NEAR(chi_square_upper_tail(18.307038053, 10), 0.05, 1e-9);  // table
}

TEST(Tails, BinomialSums) {
  // Twenty fair coins, directly summed.
  double choose = 1.0, lower = 0.0;
  for (int k = 0; k <= 20; ++k) {
    EXPECT_NEAR(binomial_upper_tail(k, 20, 0.5), 1.0 - lower, 1e-13) << k;
    lower += choose / 1048576.0;
    EXPECT_NEAR(binomial_lower_tail(k, 20, 0.5), lower, 1e-13) << k;
    choose = choose * (20 - k) / (k + 1);
  }
  EXPECT_NEAR(binomial_upper_tail(100, 100, 1e-3) / 1e-300, 1.0, 1e-10);
  EXPECT_EQ(binomial_two_sided(10, 20, 0.5), 1.0);
  EXPECT_EQ(binomial_upper_tail(21, 20, 0.5), 0.0);
}

TEST(Tails, MeanBoundHoldsForTheCoinItComesFrom) {
  EXPECT_DOUBLE_EQ(mean_lower_tail_bound(1.0, 100, 3.0), 1.0);
  EXPECT_NEAR(mean_lower_tail_bound(0.0, 10, 3.0) / std::pow(2.0 / 3.0, 10), 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(mean_lower_tail_bound(std::numeric_limits<double>::quiet_NaN(), 10, 3.0), 1.0);
  for (std::uint64_t k = 0; k < 20; ++k) {  // 60 coins that show 3 with probability 1/3
    const double exact = binomial_lower_tail(k, 60, 1.0 / 3.0),
                 bound = mean_lower_tail_bound(static_cast<double>(k) / 20.0, 60, 3.0);
    EXPECT_LE(exact, bound);
    EXPECT_LE(bound, 10.0 * exact);
  }
}

TEST(Corrections, SidakInvertsItselfAndKeepsTinyValues) {
  EXPECT_NEAR(sidak_level(0.05, 5), 1.0 - std::pow(0.95, 0.2), 1e-16);
  EXPECT_NEAR(sidak_adjust(sidak_level(0.01, 480000), 480000), 0.01, 1e-14);
  EXPECT_NEAR(sidak_adjust(1e-200, 100) / 1e-198, 1.0, 1e-12);
  EXPECT_EQ(sidak_adjust(0.3, 1), 0.3);
  EXPECT_EQ(sidak_adjust(1.0, 7), 1.0);
  EXPECT_THROW(sidak_level(0.0, 3), Error);
  EXPECT_THROW(sidak_level(1.0, 3), Error);
}

TEST(Corrections, HolmStepsDown) {
  const std::vector<double> p{0.01, 0.04, 0.03, 0.005};
  const std::vector<double> adjusted = holm_adjust(p);  // 4·0.005, 3·0.01, 2·0.03, then held at 0.06
  EXPECT_DOUBLE_EQ(adjusted[3], 0.02);
  EXPECT_DOUBLE_EQ(adjusted[0], 0.03);
  EXPECT_DOUBLE_EQ(adjusted[2], 0.06);
  EXPECT_DOUBLE_EQ(adjusted[1], 0.06);
  EXPECT_TRUE(holm_adjust({}).empty());
}

TEST(Intervals, CoverWhatTheyPromise) {
  const Interval normal = normal_interval(2.0, 0.5, 0.95);
  EXPECT_NEAR(normal.high - 2.0, 0.5 * 1.959963984540054, 1e-14);
  const Interval student = student_interval(0.0, 1.0, 10, 0.95);
  EXPECT_NEAR(student.high, 2.228138852, 1e-8);
  // Clopper–Pearson without successes has a closed form: 1 − (α/2)^(1/n).
  EXPECT_NEAR(binomial_interval(0, 30, 0.95).high, 1.0 - std::pow(0.025, 1.0 / 30.0), 1e-12);
  EXPECT_EQ(binomial_interval(0, 30, 0.95).low, 0.0);
  EXPECT_EQ(binomial_interval(30, 30, 0.95).high, 1.0);
  const Interval half = binomial_interval(5, 10, 0.95);
  EXPECT_NEAR(half.low, 0.187086, 1e-6);  // published example
  EXPECT_NEAR(half.high, 0.812914, 1e-6);
}

TEST(TTest, StatisticAndPValue) {
  const TTestResult r = t_test(1.1, 0.25, 100, 1.0);
  EXPECT_NEAR(r.t, 2.0, 1e-12);
  EXPECT_EQ(r.dof, 99.0);
  EXPECT_NEAR(r.p_value, 0.048239, 1e-6);  // table of Student's distribution, 99 degrees
  EXPECT_EQ(r.decision, Decision::statistical);
  EXPECT_NEAR(t_test(0.9, 0.25, 100, 1.0).t, r.t, 1e-12);
}

TEST(TTest, WithoutVarianceTheToleranceDecides) {
  // Furnace of albedo 0.5 and 15 segments: each path gives the same value; the reference is quoted with six digits.
  EXPECT_EQ(t_test(1.99993896484375, 0.0, 100000, 1.99994).p_value, 1.0);
  EXPECT_EQ(t_test(1.99993896484375, 0.0, 100000, 1.99994).decision, Decision::numerical);
  EXPECT_EQ(t_test(1.9998779, 0.0, 100000, 1.99994).p_value, 0.0);  // one segment too few
  EXPECT_EQ(t_test(0.0, 0.0, 100000, 0.0898394).p_value, 0.0);      // black
  EXPECT_EQ(t_test(0.0, 0.0, 100000, 0.0).p_value, 1.0);
  // Rounding noise is no better a standard deviation than none.
  EXPECT_EQ(t_test(1.99993896484375, 1e-14, 100000, 1.99994).p_value, 1.0);
  EXPECT_LT(t_test(1.9998779, 1e-14, 100000, 1.99994).p_value, 1e-100);
}

TEST(TTest, UndefinedNeverPasses) {
  EXPECT_EQ(t_test(kNan, 1.0, 100, 1.0).p_value, 0.0);
  EXPECT_EQ(t_test(1.0, kNan, 100, 1.0).p_value, 0.0);
  EXPECT_EQ(t_test(1.0, kInfinity, 100, 1.0).p_value, 0.0);
  EXPECT_EQ(t_test(kInfinity, 1.0, 100, 1.0).p_value, 0.0);
  EXPECT_THROW(t_test(1.0, 1.0, 1, 1.0), Error);
}

TEST(TTest, FalseAlarmsComeAtTheStatedRate) {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal(3.0, 2.0);
  std::exponential_distribution<double> exponential(1.0);
  std::uint64_t rejected_normal = 0, rejected_exponential = 0;
  constexpr int kExperiments = 2000;
  for (int i = 0; i < kExperiments; ++i) {
    RunningMoments a, b;
    for (int s = 0; s < 20; ++s) a.add(normal(rng));         // exact for any n
    for (int s = 0; s < 1000; ++s) b.add(exponential(rng));  // by the central limit theorem
    rejected_normal += t_test(a.mean(), a.variance(), a.n(), 3.0).p_value < 0.01;
    rejected_exponential += t_test(b.mean(), b.variance(), b.n(), 1.0).p_value < 0.01;
  }
  expect_rate(rejected_normal, kExperiments, 0.01);
  expect_rate(rejected_exponential, kExperiments, 0.01);
}

TEST(TTest, FindsABiasOfTwoPercent) {
  // Relative standard deviation 1 and n = 100 000: a 2 % bias lies 6.3 standard errors away, found with probability
  // 0.9999.
  std::mt19937_64 rng(2);
  std::exponential_distribution<double> exponential(1.0);
  int found = 0;
  for (int i = 0; i < 50; ++i) {
    RunningMoments m;
    for (int s = 0; s < 100000; ++s) m.add(1.02 * exponential(rng));
    found += t_test(m.mean(), m.variance(), m.n(), 1.0).p_value < 0.01;
  }
  EXPECT_EQ(found, 50);
}

TEST(ZTest, SignedAndTwoSided) {
  const ZTestResult r = z_test(1.0, 0.3, 2.0, 0.4);
  EXPECT_NEAR(r.z, -2.0, 1e-12);
  EXPECT_NEAR(r.p_value, 0.0455002639, 1e-9);
  EXPECT_EQ(z_test(1.0, 0.0, 1.0, 0.0).p_value, 1.0);
  EXPECT_EQ(z_test(1.0, 0.0, 1.000001, 0.0).p_value, 1.0);
  EXPECT_EQ(z_test(1.0, 0.0, 1.001, 0.0).p_value, 0.0);
  EXPECT_EQ(z_test(1.0, kInfinity, 5.0, 0.1).p_value, 1.0);
  EXPECT_EQ(z_test(kNan, 0.1, 5.0, 0.1).p_value, 0.0);
}

TEST(ChiSquare, HandCase) {
  // A die thrown 60 times: Σ(o−e)²/e = (25+4+9+4+0+4)/10... = 4.6 with five degrees of freedom.
  const std::vector<double> observed{5, 8, 13, 12, 10, 12}, expected(6, 10.0);
  const ChiSquareResult r = chi_square_test(observed, expected);
  EXPECT_NEAR(r.statistic, 4.6, 1e-12);
  EXPECT_EQ(r.dof, 5.0);
  EXPECT_NEAR(r.p_value, 0.46662, 1e-5);
  EXPECT_EQ(r.pooled, 0u);
}

TEST(ChiSquare, PoolsSmallCellsWithoutLosingSamples) {
  // Ascending: 1+2+3 = 6 is a pool, 4+20 = 24 is one, 30 stands alone.
  const std::vector<double> expected{30, 1, 4, 2, 20, 3}, observed{25, 2, 5, 2, 22, 4};
  const ChiSquareResult r = chi_square_test(observed, expected);
  EXPECT_EQ(r.cells, 3u);
  EXPECT_EQ(r.pooled, 5u);
  EXPECT_NEAR(r.statistic, 4.0 / 6.0 + 9.0 / 24.0 + 25.0 / 30.0, 1e-12);
  // Seven cells of 1: five make a pool, the rest of two joins it, and one cell has nothing to be compared with.
  const ChiSquareResult ones = chi_square_test(std::vector<double>(7, 1.0), std::vector<double>(7, 1.0));
  EXPECT_EQ(ones.cells, 1u);
  EXPECT_EQ(ones.p_value, 1.0);
}

TEST(ChiSquare, TwoCellsOfWhichOneIsRareAreTestedExactly) {
  const std::vector<double> expected = {3999.0, 1.0};
  const ChiSquareResult usual = chi_square_test(std::vector<double>{3998.0, 2.0}, expected);
  EXPECT_TRUE(usual.made);
  EXPECT_EQ(usual.cells, 2u);
  EXPECT_NEAR(usual.p_value, 2.0 * binomial_upper_tail(2, 4000, 1.0 / 4000), 1e-12);
  EXPECT_LT(chi_square_test(std::vector<double>{3985.0, 15.0}, expected).p_value, 1e-9);
  // Three cells in one pool are no test.
  EXPECT_FALSE(chi_square_test(std::vector<double>{1.0, 1.0, 1.0}, std::vector<double>{1.0, 1.0, 1.0}).made);
}

TEST(ChiSquare, SamplesWhereThereCanBeNoneAreAnError) {
  const std::vector<double> expected{500, 500, 0};
  EXPECT_EQ(chi_square_test(std::vector<double>{495, 505, 1}, expected).p_value, 0.0);
  EXPECT_GT(chi_square_test(std::vector<double>{495, 505, 0}, expected).p_value, 0.5);
  EXPECT_EQ(chi_square_test(std::vector<double>{495, 505}, std::vector<double>{kNan, 5}).p_value, 0.0);
  EXPECT_EQ(chi_square_test(std::vector<double>{495, 505}, std::vector<double>{-1, 5}).p_value, 0.0);
  EXPECT_THROW(chi_square_test(std::vector<double>{1}, expected), Error);
}

TEST(ChiSquare, FalseAlarmsComeAtTheStatedRateAndALeaningDieIsFound) {
  std::mt19937_64 rng(3);
  std::vector<double> weights(40);
  for (std::size_t i = 0; i < weights.size(); ++i)
    weights[i] = std::exp(-0.2 * static_cast<double>(i));  // the tail has to be pooled
  double sum = 0;
  for (double w : weights) sum += w;
  std::discrete_distribution<int> fair(weights.begin(), weights.end());
  auto leaning_weights = weights;
  leaning_weights[1] *= 1.1;
  std::discrete_distribution<int> leaning(leaning_weights.begin(), leaning_weights.end());
  constexpr int kSamples = 20000, kExperiments = 2000;
  auto expected = weights;
  for (double& count : expected) count *= kSamples / sum;
  std::uint64_t rejected = 0, found = 0;
  for (int i = 0; i < kExperiments; ++i) {
    std::vector<double> observed(weights.size());
    for (int s = 0; s < kSamples; ++s) observed[fair(rng)] += 1;
    rejected += chi_square_test(observed, expected).p_value < 0.01;
  }
  auto more = expected;
  for (double& e : more) e *= 5;
  for (int i = 0; i < 20; ++i) {
    std::vector<double> observed(weights.size());
    for (int s = 0; s < 5 * kSamples; ++s) observed[leaning(rng)] += 1;
    found += chi_square_test(observed, more).p_value < 0.01;
  }
  expect_rate(rejected, kExperiments, 0.01);
  EXPECT_EQ(found, 20u);
}

TEST(Tail, ParetoIsFoundAndBoundedIsNot) {
  std::mt19937_64 rng(4);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<double> pareto1, pareto4, bounded, exponential;
  for (int i = 0; i < 100000; ++i) {
    const double u = 1.0 - uniform(rng);
    pareto1.push_back(std::pow(u, -1.0 / 1.2));
    pareto4.push_back(std::pow(u, -1.0 / 4.0));
    bounded.push_back(u);
    exponential.push_back(-std::log(u));
  }
  EXPECT_TRUE(tail_report(pareto1).heavy());
  EXPECT_NEAR(tail_report(pareto1).hill_index, 1.2, 3 * tail_report(pareto1).hill_error);
  EXPECT_FALSE(tail_report(pareto4).heavy());
  EXPECT_FALSE(tail_report(bounded).heavy());
  EXPECT_FALSE(tail_report(exponential).heavy());
}

TEST(Tail, OneSampleThatDecidesEverything) {
  std::vector<double> samples(10000, 0.1);
  samples[77] = 50.0;
  const TailReport report = tail_report(samples);
  EXPECT_EQ(report.largest, 50.0);
  EXPECT_GT(report.largest_share, 0.99);
  EXPECT_TRUE(report.heavy());
  // A constant, and a constant with rounding noise, have no tail.
  EXPECT_FALSE(tail_report(std::vector<double>(1000, 0.3)).heavy());
  std::vector<double> noise(1000, 0.3);
  noise[5] = 0.30000001;
  EXPECT_FALSE(tail_report(noise).heavy());
  EXPECT_FALSE(tail_report({}).heavy());
}

TEST(Moments, StableFarFromZero) {
  RunningMoments m;
  for (int i = 0; i < 1000; ++i) m.add(1e9 + (i % 2));
  EXPECT_NEAR(m.mean(), 1e9 + 0.5, 1e-6);
  EXPECT_NEAR(m.variance(), 0.25 * 1000 / 999, 1e-6);
  EXPECT_EQ(RunningMoments().standard_error(), kInfinity);
}

}  // namespace
}  // namespace etendue
