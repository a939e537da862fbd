#include "validate/image_tests.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "validate/mean_difference.h"
#include "validate/metrics.h"

namespace etendue {
namespace {

constexpr double kLargestScore = 37.0;  // beyond it a double holds no normal tail

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
  // Beyond kLargestScore all score alike, and so does what the tolerance decided.
  const double score = r.p_value > 0.0 ? std::min(std::abs(r.z), kLargestScore) : kLargestScore;
  cell.z = std::copysign(score, std::isnan(r.difference) ? 1.0 : r.difference);
  return cell;
}

/// Accumulates a family of tests, cell by cell; only the worst cell is kept.
class FamilyTally {
 public:
  /// `most`: the largest number of tests there can be.
  FamilyTally(double level, std::uint64_t most) : level_(level), surely_(level / static_cast<double>(most)) {}

  void add(const Cell& cell) {
    if (count_ == 0 || worse(cell, worst_)) worst_ = cell;
    ++count_;
    if (cell.spread) scores_.add(cell.z);
    // Holm's procedure compares p-values with thresholds between these two.
    if (cell.p < surely_) {
      ++rejected_;
    } else if (cell.p < level_) {
      undecided_.push_back(cell.p);
    }
  }
  void merge(const FamilyTally& other) {
    if (other.count_ == 0) return;
    if (count_ == 0 || worse(other.worst_, worst_)) worst_ = other.worst_;
    count_ += other.count_;
    scores_.merge(other.scores_);
    rejected_ += other.rejected_;
    undecided_.insert(undecided_.end(), other.undecided_.begin(), other.undecided_.end());
  }

  TestFamily family(const std::string& name, std::uint64_t skipped) const {
    TestFamily family;
    family.name = name;
    family.tests = count_;
    family.skipped = skipped;
    family.family_level = level_;
    if (count_ == 0) return family;
    family.test_level = sidak_level(level_, count_);
    family.smallest_p = worst_.p;
    family.family_p = sidak_adjust(worst_.p, count_);
    family.rejected = rejected_by_holm();
    family.z_mean = scores_.mean();
    family.z_deviation = std::sqrt(scores_.variance());
    family.worst_x = worst_.x;
    family.worst_y = worst_.y;
    family.worst_channel = worst_.channel;
    family.worst_test = worst_.test;
    family.worst_reference = worst_.reference;
    family.worst_z = worst_.z;
    return family;
  }

 private:
  static bool worse(const Cell& a, const Cell& b) { return a.p < b.p || (a.p == b.p && std::abs(a.z) > std::abs(b.z)); }
  /// In ascending order each p-value is multiplied by the number of those not smaller; the first product that reaches
  /// the level ends it [Holm1979].
  std::uint64_t rejected_by_holm() const {
    std::vector<double> p_values = undecided_;
    std::sort(p_values.begin(), p_values.end());
    std::uint64_t rejected = rejected_;
    for (const double p : p_values) {
      if (static_cast<double>(count_ - rejected) * p >= level_) break;
      ++rejected;
    }
    return rejected;
  }

  double level_, surely_;
  std::uint64_t count_ = 0;
  Cell worst_;
  RunningMoments scores_;
  std::uint64_t rejected_ = 0;  ///< certainly
  std::vector<double> undecided_;
};

/// The tests of all blocks of size × size pixels that hold a testable one.
class BlockTests {
 public:
  BlockTests(const Image& test, const Image& reference, std::uint32_t size, std::uint32_t min_samples)
      : test_(test),
        reference_(reference),
        size_(size),
        min_samples_(min_samples),
        columns_((test.width + size - 1) / size),
        rows_((test.height + size - 1) / size) {}

  std::uint64_t count() const { return std::uint64_t{columns_} * rows_; }

  /// Calls visit(cell) for the three channels of a block, if anything in it can be tested.
  template <typename Visit>
  void test(std::uint64_t block, const Visit& visit) const {
    const auto x0 = static_cast<std::uint32_t>(block % columns_) * size_,
               y0 = static_cast<std::uint32_t>(block / columns_) * size_;
    std::array<MeanDifference, 3> differences;
    bool any = false;
    for (std::uint32_t y = y0; y < std::min(y0 + size_, test_.height); ++y) {
      for (std::uint32_t x = x0; x < std::min(x0 + size_, test_.width); ++x) {
        const std::size_t pixel = std::size_t{y} * test_.width + x;
        if (!testable(test_, pixel, min_samples_) || !testable(reference_, pixel, min_samples_)) continue;
        for (int channel = 0; channel < 3; ++channel)
          differences[static_cast<std::size_t>(channel)].add(test_, reference_, pixel, channel);
        any = true;
      }
    }
    if (!any) return;
    for (int channel = 0; channel < 3; ++channel)
      visit(make_cell(differences[static_cast<std::size_t>(channel)], x0, y0, channel));
  }

  TestFamily family(const std::string& name, double level) const {
    // Pieces of fixed size, put together in order: the same numbers for any number of threads.
    constexpr std::uint64_t kPiece = 1 << 14;
    const std::uint64_t most = 3 * count();
    std::vector<FamilyTally> pieces((count() + kPiece - 1) / kPiece, FamilyTally(level, most));
    parallel_for(pieces.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t piece = begin; piece < end; ++piece) {
        for (std::uint64_t block = piece * kPiece; block < std::min(count(), (piece + 1) * kPiece); ++block)
          test(block, [&](const Cell& cell) { pieces[piece].add(cell); });
      }
    });
    FamilyTally all(level, most);
    for (const FamilyTally& piece : pieces) all.merge(piece);
    const TestFamily counted = all.family(name, 0);
    return all.family(name, most - counted.tests);
  }

 private:
  const Image &test_, &reference_;
  std::uint32_t size_, min_samples_, columns_, rows_;
};

/// Whether a component differs by more than rounding; NaN and infinity always do.
bool differs(const glm::vec3& a, const glm::vec3& b) {
  for (int c = 0; c < 3; ++c) {
    const double x = a[c], y = b[c];
    if (!(std::abs(x - y) <= kNumericalTolerance * std::max(std::abs(x), std::abs(y)))) return true;
  }
  return false;
}

/// Fills in what the tests cover: differing, untested and detectable_bias.
void look_at_coverage(const Image& test, const Image& reference, ImageTests& tests) {
  std::array<MeanDifference, 3> differences;
  bool any = false;
  tests.pixels = test.pixels.size();
  for (std::size_t i = 0; i < test.pixels.size(); ++i) {
    const bool tested = testable(test, i, 2) && testable(reference, i, 2);
    if (differs(test.pixels[i], reference.pixels[i])) {
      ++tests.differing;
      tests.untested += !tested;
    }
    if (!tested) continue;
    any = true;
    for (int c = 0; c < 3; ++c) differences[static_cast<std::size_t>(c)].add(test, reference, i, c);
  }
  tests.detectable_bias = std::numeric_limits<double>::infinity();
  if (!any) return;
  const auto brightness = [](const MeanDifference& d) {
    return std::max(std::abs(d.mean_test()), std::abs(d.mean_reference()));
  };
  const MeanDifference& d = *std::max_element(
      differences.begin(), differences.end(),
      [&](const MeanDifference& a, const MeanDifference& b) { return brightness(a) < brightness(b); });
  const double needed = normal_quantile_upper(0.5 * tests.families.back().test_level) + normal_quantile_upper(0.01);
  tests.detectable_bias = d.standard_error() == 0.0 ? 0.0 : needed * d.standard_error() / brightness(d);
}

void require_statistics(const Image& test, const Image& reference) {
  require_comparable(test, reference);
  for (const Image* image : {&test, &reference}) {
    if (!image->has_statistics() || image->standard_error.size() != image->pixels.size() ||
        image->sample_count.size() != image->pixels.size()) {
      throw Error(ErrorKind::usage,
                  "statistical tests need StdErr.R, StdErr.G, StdErr.B and SampleCount in both pictures");
    }
  }
}

}  // namespace

bool ImageTests::passed() const {
  return std::all_of(families.begin(), families.end(), [](const TestFamily& f) { return f.passed(); });
}

std::string ImageTests::gap() const {
  if (made()) return "";
  if (untested > 0) {
    return fmt::format(
        "{} of {} pixels differ where there is no standard error to judge by (fewer than two samples, or an error that "
        "is infinite, NaN or negative); render more samples per pixel",
        untested, pixels);
  }
  if (spread.too_small && !shared_noise) return spread_text(spread);
  return fmt::format("the noise hides everything below {:.3g} % of the image mean; render more samples per pixel",
                     100.0 * detectable_bias);
}

ImageTests test_images(const Image& test, const Image& reference, double significance) {
  require_statistics(test, reference);
  ImageTests result;
  result.significance = significance;
  // Three families share the significance: Bonferroni, because they look at the same samples.
  const double level = significance / 3.0;
  const std::uint32_t whole = std::max(test.width, test.height);
  result.families.push_back(BlockTests(test, reference, 1, kMinPixelSamples).family("pixels", level));
  result.families.push_back(BlockTests(test, reference, kBlockSize, 2).family("8×8 blocks", level));
  result.families.push_back(BlockTests(test, reference, whole, 2).family("image mean", level));
  look_at_coverage(test, reference, result);
  result.spread = score_spread(test, reference);
  return result;
}

std::vector<glm::vec3> pixel_scores(const Image& test, const Image& reference, std::uint32_t reduction) {
  require_statistics(test, reference);
  const std::uint32_t columns = (test.width + reduction - 1) / reduction;
  const std::uint32_t rows = (test.height + reduction - 1) / reduction;
  std::vector<glm::vec3> scores(std::size_t{columns} * rows, glm::vec3(0.0f));
  const BlockTests pixels(test, reference, 1, kMinPixelSamples);
  parallel_for(rows, 8, [&](std::uint64_t begin, std::uint64_t end) {
    const std::uint64_t first = begin * reduction * test.width;
    const std::uint64_t last = std::min<std::uint64_t>(end * reduction, test.height) * test.width;
    for (std::uint64_t pixel = first; pixel < last; ++pixel) {
      pixels.test(pixel, [&](const Cell& cell) {
        float& score = scores[std::size_t{cell.y / reduction} * columns + cell.x / reduction][cell.channel];
        if (std::abs(cell.z) > std::abs(static_cast<double>(score))) score = static_cast<float>(cell.z);
      });
    }
  });
  return scores;
}

}  // namespace etendue
