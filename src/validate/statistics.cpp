#include "validate/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include "core/errors.h"

namespace etendue {
namespace {

namespace bm = boost::math;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void require_probability(double value, const char* what) {
  if (!(value > 0.0 && value < 1.0)) {
    throw Error(ErrorKind::usage, fmt::format("{} is {}, which is not between 0 and 1", what, value));
  }
}

}  // namespace

double normal_upper_tail(double z) {
  if (std::isnan(z)) return 0.0;
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

double normal_two_sided(double z) {
  if (std::isnan(z)) return 0.0;
  return std::erfc(std::abs(z) / std::sqrt(2.0));
}

double normal_quantile_upper(double upper_tail) {
  require_probability(upper_tail, "the tail probability");
  return bm::quantile(bm::complement(bm::normal(), upper_tail));
}

double student_two_sided(double t, double dof) {
  if (std::isnan(t) || !(dof > 0.0)) return 0.0;
  if (std::isinf(t)) return 0.0;
  return 2.0 * bm::cdf(bm::complement(bm::students_t(dof), std::abs(t)));
}

double chi_square_upper_tail(double x, double dof) {
  if (std::isnan(x) || !(dof > 0.0)) return 0.0;
  if (x <= 0.0) return 1.0;
  if (std::isinf(x)) return 0.0;
  return bm::cdf(bm::complement(bm::chi_squared(dof), x));
}

double binomial_upper_tail(std::uint64_t k, std::uint64_t n, double prob) {
  if (k == 0) return 1.0;
  if (k > n) return 0.0;
  const bm::binomial distribution(static_cast<double>(n), prob);
  return bm::cdf(bm::complement(distribution, static_cast<double>(k - 1)));
}

double binomial_lower_tail(std::uint64_t k, std::uint64_t n, double prob) {
  if (k >= n) return 1.0;
  return bm::cdf(bm::binomial(static_cast<double>(n), prob), static_cast<double>(k));
}

double binomial_two_sided(std::uint64_t k, std::uint64_t n, double prob) {
  return std::min(1.0, 2.0 * std::min(binomial_lower_tail(k, n, prob), binomial_upper_tail(k, n, prob)));
}

double mean_lower_tail_bound(double mean, std::uint64_t n, double second_moment) {
  if (!(mean < 1.0)) return 1.0;
  const double q = 1.0 / second_moment, p = std::max(mean, 0.0) * q;
  const double divergence =
      (p > 0.0 ? p * std::log(p / q) : 0.0) + (p < 1.0 && q < 1.0 ? (1.0 - p) * std::log((1.0 - p) / (1.0 - q)) : 0.0);
  return std::exp(-static_cast<double>(n) * divergence);
}

double sidak_level(double family_alpha, std::uint64_t tests) {
  require_probability(family_alpha, "the significance level");
  if (tests <= 1) return family_alpha;
  return -std::expm1(std::log1p(-family_alpha) / static_cast<double>(tests));
}

double sidak_adjust(double p, std::uint64_t tests) {
  if (p >= 1.0) return 1.0;
  return -std::expm1(static_cast<double>(tests) * std::log1p(-p));
}

std::vector<double> holm_adjust(std::span<const double> p_values) {
  const std::size_t m = p_values.size();
  std::vector<std::size_t> order(m);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(m);
  double largest = 0.0;
  for (std::size_t rank = 0; rank < m; ++rank) {
    // Adjusted values may not fall along the sorted order: once a hypothesis stands, all after it stand.
    largest = std::max(largest, std::min(1.0, static_cast<double>(m - rank) * p_values[order[rank]]));
    adjusted[order[rank]] = largest;
  }
  return adjusted;
}

Interval normal_interval(double mean, double standard_error, double level) {
  require_probability(level, "the confidence level");
  if (standard_error == 0.0) return {mean, mean};
  const double half = normal_quantile_upper(0.5 * (1.0 - level)) * standard_error;
  return {mean - half, mean + half};
}

Interval student_interval(double mean, double standard_error, double dof, double level) {
  require_probability(level, "the confidence level");
  if (standard_error == 0.0) return {mean, mean};
  if (!(dof > 0.0)) return {-kInfinity, kInfinity};
  const double half = bm::quantile(bm::complement(bm::students_t(dof), 0.5 * (1.0 - level))) * standard_error;
  return {mean - half, mean + half};
}

Interval binomial_interval(std::uint64_t k, std::uint64_t n, double level) {
  require_probability(level, "the confidence level");
  if (n == 0) return {0.0, 1.0};
  const double tail = 0.5 * (1.0 - level);
  const auto trials = static_cast<double>(n);
  const auto successes = static_cast<double>(k);
  const double low = k == 0 ? 0.0 : bm::binomial::find_lower_bound_on_p(trials, successes, tail);
  const double high = k == n ? 1.0 : bm::binomial::find_upper_bound_on_p(trials, successes, tail);
  return {low, high};
}

TTestResult t_test(double mean, double variance, std::uint64_t n, double reference, double relative_tolerance) {
  if (n < 2) {
    throw Error(ErrorKind::usage,
                fmt::format("a t-test of {} sample(s) has no variance to work with; use at least 2", n));
  }
  TTestResult result;
  result.mean = mean;
  result.variance = variance;
  result.n = n;
  result.reference = reference;
  result.dof = static_cast<double>(n - 1);
  result.standard_error = std::sqrt(variance / static_cast<double>(n));
  result.tolerance = relative_tolerance * std::max(std::abs(mean), std::abs(reference));
  const double difference = std::abs(mean - reference);
  if (!std::isfinite(difference) || !std::isfinite(variance) || variance < 0.0) {
    result.t = std::numeric_limits<double>::quiet_NaN();
    result.p_value = 0.0;
    return result;
  }
  result.t = difference == 0.0 ? 0.0 : difference / result.standard_error;
  const bool within = difference <= result.tolerance;
  if (variance == 0.0 || (within && result.standard_error < result.tolerance)) {
    result.decision = Decision::numerical;
    result.p_value = within ? 1.0 : 0.0;
    return result;
  }
  result.p_value = student_two_sided(result.t, result.dof);
  return result;
}

double detectable_difference(const TTestResult& test, double level) {
  if (test.n < 2) return kInfinity;
  if (test.decision == Decision::numerical) return 0.0;
  const double quantile = bm::quantile(bm::complement(bm::students_t(test.dof), 0.5 * level));
  return (quantile + normal_quantile_upper(0.01)) * test.standard_error;
}

bool is_conclusive(const TTestResult& test, double level) {
  if (test.n < 2) return false;
  return test.p_value < level ||
         detectable_difference(test, level) <= std::max(std::abs(test.mean), std::abs(test.reference));
}

ZTestResult z_test(double mean_a, double standard_error_a, double mean_b, double standard_error_b,
                   double relative_tolerance) {
  ZTestResult result;
  result.difference = mean_a - mean_b;
  result.standard_error = std::hypot(standard_error_a, standard_error_b);
  if (!std::isfinite(result.difference) || std::isnan(result.standard_error)) {
    result.z = std::numeric_limits<double>::quiet_NaN();
    result.p_value = 0.0;
    return result;
  }
  if (result.difference == 0.0 || std::isinf(result.standard_error)) {
    result.p_value = 1.0;
    return result;
  }
  const double tolerance = relative_tolerance * std::max(std::abs(mean_a), std::abs(mean_b));
  if (result.standard_error < tolerance) result.decision = Decision::numerical;
  result.z = result.difference / std::max(result.standard_error, tolerance);
  // Without any variance the tolerance is a bound, not a standard deviation.
  if (result.standard_error == 0.0) {
    result.p_value = std::abs(result.difference) <= tolerance ? 1.0 : 0.0;
    return result;
  }
  result.p_value = normal_two_sided(result.z);
  return result;
}

namespace {

struct Bin {
  double observed = 0;
  double expected = 0;
  std::size_t members = 0;
};

/// Joins cells of positive expectation, in ascending order of it, until each has at least `min_expected`.
std::vector<Bin> pool_cells(std::span<const double> observed, std::span<const double> expected, double min_expected) {
  std::vector<std::size_t> order(expected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  std::vector<Bin> cells;
  Bin open;
  for (std::size_t i : order) {
    if (expected[i] == 0.0) continue;
    open.observed += observed[i];
    open.expected += expected[i];
    ++open.members;
    if (open.expected >= min_expected) cells.push_back(std::exchange(open, Bin{}));
  }
  if (open.members > 0) {  // a rest too small for a cell of its own joins the last one
    if (cells.empty()) cells.emplace_back();
    cells.back().observed += open.observed;
    cells.back().expected += open.expected;
    cells.back().members += open.members;
  }
  return cells;
}

/// Two cells of which one expects too little for Pearson's test, such as glass that reflects one sample in a thousand:
/// the exact binomial test of the rarer one instead. False when there are more cells, or fewer.
bool test_two_cells(std::span<const double> observed, std::span<const double> expected, ChiSquareResult& result) {
  std::vector<Bin> cells;
  for (std::size_t i = 0; i < expected.size() && cells.size() < 3; ++i) {
    if (expected[i] > 0.0) cells.push_back({observed[i], expected[i], 1});
  }
  if (cells.size() != 2) return false;
  if (cells[1].expected < cells[0].expected) std::swap(cells[0], cells[1]);
  const double samples = std::round(cells[0].observed + cells[1].observed);
  if (samples < 1.0) return false;
  const double prob = cells[0].expected / (cells[0].expected + cells[1].expected);
  result.statistic = 0.0;
  for (const Bin& cell : cells)
    result.statistic += (cell.observed - cell.expected) * (cell.observed - cell.expected) / cell.expected;
  result.cells = 2;
  result.dof = 1.0;
  result.pooled = 0;
  result.p_value = binomial_two_sided(static_cast<std::uint64_t>(std::round(cells[0].observed)),
                                      static_cast<std::uint64_t>(samples), prob);
  return true;
}

}  // namespace

ChiSquareResult chi_square_test(std::span<const double> observed, std::span<const double> expected,
                                const ChiSquareOptions& options) {
  if (observed.size() != expected.size()) {
    throw Error(ErrorKind::usage,
                fmt::format("a chi-square test needs as many observed cells as expected ones, not {} and {}",
                            observed.size(), expected.size()));
  }
  ChiSquareResult result;
  double total = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!std::isfinite(expected[i]) || expected[i] < 0.0 || !std::isfinite(observed[i])) return result;  // p = 0
    total += observed[i];
    if (expected[i] == 0.0) result.impossible += observed[i];
  }
  const std::vector<Bin> cells = pool_cells(observed, expected, options.min_expected);
  for (const Bin& cell : cells) {
    const double difference = cell.observed - cell.expected;
    result.statistic += difference * difference / cell.expected;
    if (cell.members > 1) result.pooled += cell.members;
  }
  result.cells = cells.size();
  result.dof = static_cast<double>(cells.size()) - 1.0;
  if (result.impossible > options.impossible_share * total) return result;  // p = 0
  if (cells.size() < 2 && test_two_cells(observed, expected, result)) return result;
  result.p_value = cells.size() < 2 ? 1.0 : chi_square_upper_tail(result.statistic, result.dof);
  // One cell that the density itself leaves alone is tested by what is impossible.
  result.made = cells.size() >= 2 || result.pooled == 0;
  return result;
}

TailReport tail_report(std::span<const double> samples) {
  TailReport report;
  report.n = samples.size();
  report.hill_index = kInfinity;
  if (samples.empty()) return report;
  RunningMoments moments;
  for (double x : samples) moments.add(x);
  report.mean = moments.mean();

  std::vector<double> deviations(samples.size());
  double sum_squares = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    deviations[i] = std::abs(samples[i] - report.mean);
    sum_squares += deviations[i] * deviations[i];
  }
  const auto farthest = std::max_element(deviations.begin(), deviations.end());
  report.largest = samples[static_cast<std::size_t>(farthest - deviations.begin())];
  // Rounding noise around a constant does not count as a tail.
  const double scale = kNumericalTolerance * std::abs(report.mean);
  if (sum_squares > 0.0 && *farthest > scale) report.largest_share = *farthest * *farthest / sum_squares;

  constexpr std::size_t kMinSamples = 100;
  if (samples.size() < kMinSamples || *farthest <= scale) return report;
  const auto k = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(samples.size()))));
  std::partial_sort(deviations.begin(), deviations.begin() + static_cast<std::ptrdiff_t>(k + 1), deviations.end(),
                    std::greater<>());
  report.hill_count = k;
  if (deviations[k] <= 0.0) return report;  // fewer than k samples differ from the mean: the share above says so
  double log_sum = 0.0;
  for (std::size_t i = 0; i < k; ++i) log_sum += std::log(deviations[i] / deviations[k]);
  if (log_sum > 0.0) report.hill_index = static_cast<double>(k) / log_sum;
  report.hill_error = report.hill_index / std::sqrt(static_cast<double>(k));
  return report;
}

double RunningMoments::standard_error() const {
  return n_ < 2 ? kInfinity : std::sqrt(variance() / static_cast<double>(n_));
}

}  // namespace etendue
