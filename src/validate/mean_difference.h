#pragma once
/// The difference of two means with standard errors, as all tests of pictures score it.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "image/image.h"
#include "validate/statistics.h"

namespace etendue {

/// Difference of two sums of independent means, gathered term by term. The variance is that under the hypothesis
/// tested: samples of both pictures spread around their common mean. A pixel that shows all of a light in one picture
/// and nothing of it in the other has no variance of its own in either, but a large one around the common mean; its
/// score stays what chance allows.
class MeanDifference {
 public:
  void add(const Image& test, const Image& reference, std::size_t pixel, int channel) {
    const double a = test.pixels[pixel][channel], b = reference.pixels[pixel][channel];
    const double n_a = test.sample_count[pixel], n_b = reference.sample_count[pixel];
    const double common = (n_a * a + n_b * b) / (n_a + n_b);
    const double unbiased = (n_a + n_b) / (n_a + n_b - 1.0);
    variance_ += unbiased * (variance(test.standard_error[pixel][channel], n_a, a - common) +
                             variance(reference.standard_error[pixel][channel], n_b, b - common));
    sum_test_ += a;
    sum_reference_ += b;
    has_spread_ |= test.standard_error[pixel][channel] > 0.0f || reference.standard_error[pixel][channel] > 0.0f;
    ++terms_;
  }

  double mean_test() const { return sum_test_ / static_cast<double>(terms_); }
  double mean_reference() const { return sum_reference_ / static_cast<double>(terms_); }
  double standard_error() const { return std::sqrt(variance_) / static_cast<double>(terms_); }
  /// Some sample differs from another of its picture.
  bool has_spread() const { return has_spread_; }
  /// Square of the score, of expectation 1; negative where rounding alone would decide.
  double square() const {
    const double difference = sum_test_ - sum_reference_;
    const double tolerance = kNumericalTolerance * std::max(std::abs(sum_test_), std::abs(sum_reference_));
    return has_spread_ && variance_ > tolerance * tolerance ? difference * difference / variance_ : -1.0;
  }
  ZTestResult test() const { return z_test(mean_test(), standard_error(), mean_reference(), 0.0); }

 private:
  /// Of a mean of n samples, around a common mean that lies `offset` away.
  static double variance(double standard_error, double n, double offset) {
    return standard_error * standard_error * (n - 1.0) / n + offset * offset / n;
  }

  double sum_test_ = 0, sum_reference_ = 0;
  double variance_ = 0;  ///< of the difference of the sums
  bool has_spread_ = false;
  std::uint64_t terms_ = 0;
};

/// Whether a pixel has enough samples and valid standard errors.
inline bool testable(const Image& image, std::size_t pixel, std::uint32_t min_samples) {
  const glm::vec3& e = image.standard_error[pixel];
  const auto usable = [](float error) { return std::isfinite(error) && error >= 0.0f; };
  return image.sample_count[pixel] >= min_samples && usable(e.x) && usable(e.y) && usable(e.z);
}

}  // namespace etendue
