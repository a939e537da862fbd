#include "validate/image_tests.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "validate/metrics.h"

namespace etendue {
namespace {

constexpr double kLargestScore = 37.0;  // beyond it a double holds no normal tail

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

/// One tested mean.
struct Cell {
  std::uint32_t x = 0, y = 0;
  int channel = 0;
  double test = 0, reference = 0;
  double p = 1;
  double z = 0;         ///< signed normal score of p
  bool spread = false;  ///< has variance, so that its score counts in the histogram
};

Cell make_cell(const MeanDifference& difference, std::uint32_t x, std::uint32_t y, int channel) {
  const ZTestResult r = difference.test();
  Cell cell{
      x, y, channel, difference.mean_test(), difference.mean_reference(), r.p_value, 0.0, difference.has_spread()};
  if (r.p_value >= 1.0) return cell;
  // Two-sided tails below 2·10⁻³⁰⁰ all score alike.
  const double score = r.p_value < 2e-300 ? kLargestScore : normal_quantile_upper(0.5 * r.p_value);
  cell.z = std::copysign(score, std::isnan(r.difference) ? 1.0 : r.difference);
  return cell;
}

bool testable(const Image& image, std::size_t pixel, std::uint32_t min_samples) {
  const glm::vec3& e = image.standard_error[pixel];
  return image.sample_count[pixel] >= min_samples && std::isfinite(e.x) && std::isfinite(e.y) && std::isfinite(e.z);
}

TestFamily judge(const std::string& name, const std::vector<Cell>& cells, std::uint64_t skipped, double level) {
  TestFamily family;
  family.name = name;
  family.tests = cells.size();
  family.skipped = skipped;
  family.family_level = level;
  if (cells.empty()) return family;
  family.test_level = sidak_level(level, cells.size());
  RunningMoments scores;
  std::vector<double> p_values;
  p_values.reserve(cells.size());
  const Cell* worst = &cells.front();
  for (const Cell& cell : cells) {
    p_values.push_back(cell.p);
    if (cell.p < worst->p || (cell.p == worst->p && std::abs(cell.z) > std::abs(worst->z))) worst = &cell;
    if (cell.spread) scores.add(cell.z);
  }
  family.smallest_p = worst->p;
  family.family_p = sidak_adjust(worst->p, cells.size());
  for (const double adjusted : holm_adjust(p_values)) family.rejected += adjusted < level;
  family.z_mean = scores.mean();
  family.z_deviation = std::sqrt(scores.variance());
  family.worst_x = worst->x;
  family.worst_y = worst->y;
  family.worst_channel = worst->channel;
  family.worst_test = worst->test;
  family.worst_reference = worst->reference;
  family.worst_z = worst->z;
  return family;
}

/// Tests the means over every block of size × size pixels.
TestFamily test_blocks(const Image& test, const Image& reference, std::uint32_t size, std::uint32_t min_samples,
                       const std::string& name, double level, std::vector<glm::vec3>* scores) {
  const std::uint32_t columns = (test.width + size - 1) / size, rows = (test.height + size - 1) / size;
  std::vector<Cell> all(std::size_t{3} * columns * rows);
  std::vector<char> valid(all.size(), 0);
  parallel_for(std::uint64_t{columns} * rows, 256, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t block = begin; block < end; ++block) {
      const auto x0 = static_cast<std::uint32_t>(block % columns) * size,
                 y0 = static_cast<std::uint32_t>(block / columns) * size;
      for (int channel = 0; channel < 3; ++channel) {
        MeanDifference difference;
        bool any = false;
        for (std::uint32_t y = y0; y < std::min(y0 + size, test.height); ++y) {
          for (std::uint32_t x = x0; x < std::min(x0 + size, test.width); ++x) {
            const std::size_t pixel = std::size_t{y} * test.width + x;
            if (!testable(test, pixel, min_samples) || !testable(reference, pixel, min_samples)) continue;
            difference.add(test, reference, pixel, channel);
            any = true;
          }
        }
        if (!any) continue;
        const std::size_t i = block * 3 + static_cast<std::size_t>(channel);
        all[i] = make_cell(difference, x0, y0, channel);
        valid[i] = 1;
        if (scores) (*scores)[std::size_t{y0} * test.width + x0][channel] = static_cast<float>(all[i].z);
      }
    }
  });
  std::vector<Cell> cells;
  cells.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (valid[i]) cells.push_back(all[i]);
  }
  return judge(name, cells, all.size() - cells.size(), level);
}

/// Smallest relative difference of the green image means that the test finds with probability 0.99.
double detectable_bias(const Image& test, const Image& reference, double test_level) {
  MeanDifference difference;
  bool any = false;
  for (std::size_t i = 0; i < test.pixels.size(); ++i) {
    if (!testable(test, i, 2) || !testable(reference, i, 2)) continue;
    difference.add(test, reference, i, 1);
    any = true;
  }
  if (!any || difference.mean_reference() == 0.0) return 0.0;
  const double needed = normal_quantile_upper(0.5 * test_level) + normal_quantile_upper(0.01);
  return needed * difference.standard_error() / std::abs(difference.mean_reference());
}

}  // namespace

bool ImageTests::passed() const {
  return std::all_of(families.begin(), families.end(), [](const TestFamily& f) { return f.passed(); });
}

ImageTests test_images(const Image& test, const Image& reference, double significance) {
  require_comparable(test, reference);
  for (const Image* image : {&test, &reference}) {
    if (!image->has_statistics() || image->standard_error.size() != image->pixels.size() ||
        image->sample_count.size() != image->pixels.size()) {
      throw Error(ExitCode::usage,
                  "statistical tests need StdErr.R, StdErr.G, StdErr.B and SampleCount in both pictures");
    }
  }
  ImageTests result;
  result.significance = significance;
  // Three families share the significance: Bonferroni, because they look at the same samples.
  const double level = significance / 3.0;
  result.z.assign(test.pixels.size(), glm::vec3(0.0f));
  const std::uint32_t whole = std::max(test.width, test.height);
  result.families.push_back(test_blocks(test, reference, 1, kMinPixelSamples, "pixels", level, &result.z));
  result.families.push_back(test_blocks(test, reference, kBlockSize, 2, "8×8 blocks", level, nullptr));
  result.families.push_back(test_blocks(test, reference, whole, 2, "image mean", level, nullptr));
  result.detectable_bias = detectable_bias(test, reference, result.families.back().test_level);
  return result;
}

}  // namespace etendue
