#pragma once
/// Tests whether two pictures with standard errors have the same expectation. Three families of two-sided tests, each
/// with its own family-wise false-alarm rate: every pixel, every 8×8 block, the whole image; red, green and blue apart.

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "validate/score_spread.h"
#include "validate/statistics.h"

namespace etendue {

/// Samples that a pixel needs in both pictures to be tested by itself; with fewer, its score is far from normal.
inline constexpr std::uint32_t kMinPixelSamples = 16;
inline constexpr std::uint32_t kBlockSize = 8;

struct TestFamily {
  std::string name;           ///< "pixels", "8×8 blocks", "image mean"
  std::uint64_t tests = 0;    ///< means tested, three channels each; 0: nothing to test
  std::uint64_t skipped = 0;  ///< left out for want of samples
  double family_level = 0;    ///< false-alarm rate of the family
  double test_level = 0;      ///< of one test (Šidák)
  double smallest_p = 1;
  double family_p = 1;                     ///< of the smallest p (Šidák)
  std::uint64_t rejected = 0;              ///< tests that Holm's procedure rejects at the family level
  double z_mean = 0, z_deviation = 0;      ///< of the z-scores that have variance: 0 and 1 when all is well
  std::uint32_t worst_x = 0, worst_y = 0;  ///< first pixel of the worst place
  int worst_channel = 0;                   ///< 0 red, 1 green, 2 blue
  double worst_test = 0, worst_reference = 0, worst_z = 0;  ///< means and score there
  bool passed() const { return tests == 0 || family_p >= family_level; }
};

/// Largest relative bias that may go unnoticed before a test of a mean says nothing.
inline constexpr double kBlindBias = 1.0;

struct ImageTests {
  double significance = 0;           ///< false-alarm rate of everything together
  std::vector<TestFamily> families;  ///< pixels, blocks, image mean
  /// Relative bias of the mean of the image's brightest channel that would be found with probability 0.99; infinite
  /// when no pixel could be tested.
  double detectable_bias = 0;
  std::uint64_t pixels = 0;     ///< of the picture
  std::uint64_t differing = 0;  ///< pixels that differ by more than kNumericalTolerance
  /// Of those, pixels that no test looked at: fewer than two samples in one of the pictures, or a standard error that
  /// is infinite, NaN or negative.
  std::uint64_t untested = 0;
  ScoreSpread spread;  ///< whether the scores spread as those of independent pictures do
  /// Both pictures have the same noise by what is known of them, which explains scores that are too small: the errors
  /// may be right, and the tests see less than there is.
  bool shared_noise = false;

  /// No test rejects. Says nothing by itself when the tests could not be made.
  bool passed() const;
  /// Every pixel that differs was tested, with power enough to find a bias of kBlindBias, by standard errors that can
  /// be believed. Pixels that agree need no test.
  bool made() const {
    const bool believed = !spread.too_small || shared_noise;
    return untested == 0 && (differing == 0 || (believed && detectable_bias <= kBlindBias));
  }
  /// What was not tested and what would help, one sentence without a full stop; "" when everything was.
  std::string gap() const;
};

/// A score test per mean: the variance is that of all samples around the mean common to both pictures, which keeps its
/// false-alarm rate where samples are few and discrete (measured in the unit tests). The score of n samples against n
/// is at most √(2n): with 16 samples per pixel of a large picture can hardly be rejected on its own; blocks and the
/// image mean carry the power. Differences within kNumericalTolerance are never significant. Throws Error(usage) when a
/// picture has no statistics or the sizes differ.
ImageTests test_images(const Image& test, const Image& reference, double significance = 0.01);

/// Scores of the pixels, red, green and blue apart; 0 where not tested. Of each square of `reduction` × `reduction`
/// pixels (smaller at the right and lower border) the score farthest from 0. Throws like test_images.
std::vector<glm::vec3> pixel_scores(const Image& test, const Image& reference, std::uint32_t reduction = 1);

}  // namespace etendue
