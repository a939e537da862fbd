#pragma once
/// Do two pictures with standard errors show the same expectation? Three families of two-sided tests, each with its own
/// family-wise false-alarm rate: every pixel, every 8×8 block, the whole image; red, green and blue apart.

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "validate/statistics.h"

namespace etendue {

/// Samples a pixel needs in both pictures to be tested on its own: with fewer its score is far from normal.
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

struct ImageTests {
  double significance = 0;           ///< false-alarm rate of everything together
  std::vector<TestFamily> families;  ///< pixels, blocks, image mean
  /// Relative bias of the image's luminance-heavy channel (green) that would be found with probability 0.99.
  double detectable_bias = 0;
  std::vector<glm::vec3> z;  ///< score per pixel and channel; 0 where not tested
  bool passed() const;
};

/// A score test per mean: the variance is that of all samples around the mean common to both pictures, which keeps its
/// false-alarm rate where samples are few and discrete (measured in the unit tests). The score of n samples against n
/// is at most √(2n): with 16 samples a pixel of a large picture can hardly be rejected on its own; blocks and the image
/// mean carry the power. Differences within kNumericalTolerance are never significant. Throws Error(usage) when a
/// picture has no statistics or the sizes differ.
ImageTests test_images(const Image& test, const Image& reference, double significance = 0.01);

}  // namespace etendue
