#pragma once
/// Statistics behind every verdict: tests, their tails, corrections for many tests, intervals and tail diagnostics.
/// All p-values are computed from upper tails directly (never as 1 − cdf), so that 1e-200 is as exact as 0.2. Sources
/// are keys into docs/references.md.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace etendue {

// --- Tails
// -------------------------------------------------------------------------------------------------------------

/// P(Z > z) of the standard normal distribution.
double normal_upper_tail(double z);
/// P(|Z| > |z|); 1 at 0, 0 at infinity, 0 for NaN (an undefined statistic never passes).
double normal_two_sided(double z);
/// z with P(Z > z) = `upper_tail`, `upper_tail` in (0,1).
double normal_quantile_upper(double upper_tail);
/// P(|T| > |t|) of Student's distribution with `dof` > 0 degrees of freedom; 0 for NaN.
double student_two_sided(double t, double dof);
/// P(X > x) of the chi-square distribution with `dof` > 0 degrees of freedom; 0 for NaN.
double chi_square_upper_tail(double x, double dof);
/// P(K >= k) for K binomial with `n` trials of probability `prob`.
double binomial_upper_tail(std::uint64_t k, std::uint64_t n, double prob);
/// P(K <= k).
double binomial_lower_tail(std::uint64_t k, std::uint64_t n, double prob);
/// Twice the smaller tail, at most 1.
double binomial_two_sided(std::uint64_t k, std::uint64_t n, double prob);

/// Bound of P(mean of `n` independent variables <= `mean`), each not negative, of expectation at least 1 and second
/// moment at most `second_moment` >= 1: exp(−n D(mean/second ‖ 1/second)), D the relative entropy of two coins;
/// Chernoff's bound with the moment-generating function of the coin {0, second_moment}, the largest there is
/// [Bennett1962].
double mean_lower_tail_bound(double mean, std::uint64_t n, double second_moment);

// --- Many tests at once
// ------------------------------------------------------------------------------------------------

/// Significance each of `tests` independent tests may have so that the family has `family_alpha`: 1 − (1 − α)^(1/m)
/// [Sidak1967]. Exact for independent tests, conservative for two-sided normal tests of any correlation.
double sidak_level(double family_alpha, std::uint64_t tests);
/// The family-wise p-value of the smallest of `tests` p-values: 1 − (1 − p)^m, accurate for tiny p.
double sidak_adjust(double p, std::uint64_t tests);
/// Holm's step-down adjusted p-values [Holm1979], in the order given: hypothesis i is rejected at family level α when
/// its adjusted value is < α, under any dependence.
std::vector<double> holm_adjust(std::span<const double> p_values);

// --- Intervals
// ---------------------------------------------------------------------------------------------------------

struct Interval {
  double low = 0;
  double high = 0;
  bool contains(double x) const { return low <= x && x <= high; }
};
/// Two-sided interval mean ± z · standard_error that covers with probability `level` in (0,1).
Interval normal_interval(double mean, double standard_error, double level);
/// The same with Student's quantile.
Interval student_interval(double mean, double standard_error, double dof, double level);
/// Exact interval of a proportion [Clopper1934]; covers with at least `level`.
Interval binomial_interval(std::uint64_t k, std::uint64_t n, double level);

// --- Tests
// -------------------------------------------------------------------------------------------------------------

/// Relative difference that float32 rendering and a reference quoted with six digits can have without an error in
/// either: 6 · 10⁻⁸ rounding a step over some dozens of steps, and 5 · 10⁻⁶ for a reference such as 1.00000. Smaller
/// differences are never called significant, however small the variance; an estimator without variance is judged by it
/// alone.
inline constexpr double kNumericalTolerance = 1e-5;

/// How a test came to its p-value.
enum class Decision {
  statistical,  ///< by the distribution of the statistic
  numerical,    ///< by the numerical tolerance: p is 1 (within) or 0 (outside)
};

struct TTestResult {
  double mean = 0;
  double variance = 0;  ///< of one sample
  std::uint64_t n = 0;
  double reference = 0;
  double standard_error = 0;  ///< sqrt(variance / n)
  double t = 0;               ///< |mean − reference| / standard_error; infinite without variance, 0 when equal
  double dof = 0;             ///< n − 1
  double p_value = 0;         ///< two-sided
  double tolerance = 0;       ///< absolute difference that counts as rounding
  Decision decision = Decision::statistical;
};
/// One-sample two-sided Student test of a mean of `n` >= 2 samples with unbiased `variance` against `reference`. A
/// difference of at most `relative_tolerance` · max(|mean|, |reference|) is decided numerically when the standard error
/// is smaller still. A mean or variance that is not finite gives p = 0. Throws Error(usage) when n < 2.
TTestResult t_test(double mean, double variance, std::uint64_t n, double reference,
                   double relative_tolerance = kNumericalTolerance);

/// Smallest |mean − reference| that the test at `level` would find with probability 0.99, about; 0 where the tolerance
/// decides, infinite for n < 2.
double detectable_difference(const TTestResult& test, double level);
/// Whether the test says anything: it rejects at `level`, or it would have found a mean off by as much as the larger of
/// mean and reference. A test that is not conclusive must not be counted as passed.
bool is_conclusive(const TTestResult& test, double level);

struct ZTestResult {
  double difference = 0;      ///< a − b
  double standard_error = 0;  ///< of the difference
  double z = 0;               ///< signed
  double p_value = 0;         ///< two-sided
  Decision decision = Decision::statistical;
};
/// Two independent means with known standard errors. Differences within the tolerance (relative to max(|a|, |b|)) have
/// z limited by it: z = difference / max(standard_error, tolerance), so that constant pixels compare by tolerance and
/// not by division by 0. Infinite standard errors (fewer than two samples) carry no information: p = 1, so that a
/// caller who wants a verdict must leave such means out and say so (ImageTests::untested).
ZTestResult z_test(double mean_a, double standard_error_a, double mean_b, double standard_error_b,
                   double relative_tolerance = kNumericalTolerance);

struct ChiSquareOptions {
  double min_expected = 5.0;  ///< cells with less are pooled [Cochran1954]
  double impossible_share =
      1e-5;  ///< share of all samples that may lie in cells of expectation 0 (rounding at cell borders)
};
struct ChiSquareResult {
  double statistic = 0;
  std::size_t cells = 0;   ///< terms of the statistic, pools included
  std::size_t pooled = 0;  ///< input cells that went into pools
  double dof = 0;          ///< cells − 1
  double p_value = 0;
  double impossible = 0;  ///< samples in cells of expectation 0
  bool made = true;       ///< false: too few samples, all cells that expect any ended in one pool
};
/// Pearson's test of counts against expectations with the same total: a caller whose density integrates to less than 1
/// adds the rest (samples rejected) as a cell of its own. Cells are pooled in ascending order of expectation. Two cells
/// that pooling would join are tested by the binomial distribution of the rarer one instead. With a
/// single cell left there is nothing to test: p = 1, and `made` says whether that is for want of samples. Samples in
/// impossible cells beyond the allowed share, or expectations that are negative or not finite, give p = 0. Throws
/// Error(usage) when the sizes differ.
ChiSquareResult chi_square_test(std::span<const double> observed, std::span<const double> expected,
                                const ChiSquareOptions& options = {});

// --- Is the variance to be believed?
// -----------------------------------------------------------------------------------

/// Heavy tails make a sample variance meaningless: the rare sample that matters has not been seen yet, or was seen
/// once.
struct TailReport {
  std::uint64_t n = 0;
  double mean = 0;
  double largest = 0;        ///< sample farthest from the mean
  double largest_share = 0;  ///< its share of Σ(x − mean)²; 0 without variance
  double hill_index =
      0;  ///< tail index α of |x − mean| [Hill1975]: moments of order >= α do not exist; infinite for bounded tails
  double hill_error = 0;       ///< standard error α/√k
  std::size_t hill_count = 0;  ///< order statistics used, k
  bool heavy() const { return largest_share > kMaxShare || hill_index < kMinIndex; }

  static constexpr double kMaxShare = 0.05;  ///< one of 20 effective samples: normal theory needs more
  static constexpr double kMinIndex = 2.0;   ///< below it the variance is infinite
};
/// Looks at the samples themselves; k = ⌈√n⌉ top order statistics. Fewer than 100 samples give a report that is never
/// heavy by the Hill index.
TailReport tail_report(std::span<const double> samples);

/// Mean and unbiased variance in one stable pass [Welford1962].
class RunningMoments {
 public:
  void add(double x) {
    ++n_;
    const double delta = x - mean_;
    mean_ += delta / static_cast<double>(n_);
    sum_squares_ += delta * (x - mean_);
  }
  /// As if the other's values had been added here [Chan1983].
  void merge(const RunningMoments& other) {
    if (other.n_ == 0) return;
    const auto n = static_cast<double>(n_), m = static_cast<double>(other.n_);
    const double delta = other.mean_ - mean_;
    mean_ += delta * m / (n + m);
    sum_squares_ += other.sum_squares_ + delta * delta * n * m / (n + m);
    n_ += other.n_;
  }
  std::uint64_t n() const { return n_; }
  double mean() const { return mean_; }
  double variance() const { return n_ < 2 ? 0.0 : sum_squares_ / static_cast<double>(n_ - 1); }
  double standard_error() const;  ///< infinite with fewer than two samples

 private:
  std::uint64_t n_ = 0;
  double mean_ = 0;
  double sum_squares_ = 0;
};

}  // namespace etendue
