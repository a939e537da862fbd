#pragma once
/// Distances between two pictures, from the papers. `test` is the picture in question, `reference` what it is held
/// against; both are linear Rec. 709. All sums are over pixels where both are finite; the others are counted.

#include <cstdint>
#include <vector>

#include "image/image.h"
#include "validate/statistics.h"

namespace etendue {

/// Throws Error(usage) when the sizes differ.
void require_same_size(std::uint32_t test_width, std::uint32_t test_height, std::uint32_t reference_width,
                       std::uint32_t reference_height);
/// Throws Error(usage) when the sizes differ or a picture has no pixels.
void require_comparable(const Image& test, const Image& reference);

/// Rec. 709 → display value in [0,1]: clamped and sRGB-encoded (IEC 61966-2-1). NaN becomes 0.
double srgb_encode(double linear);
double srgb_decode(double encoded);

struct Metrics {
  double mse = 0;  ///< mean squared difference over pixels and channels
  double rmse = 0;
  double rel_mse = 0;        ///< mean of (a − b)² / (b² + 0.01), b the reference [Rousselle2011]
  double mae = 0;            ///< mean absolute difference
  double psnr = 0;           ///< dB, of display values (clamped, sRGB), peak 1; infinite when equal
  double ssim = 0;           ///< of the luma of display values [Wang2004]; 1 when equal
  double flip = 0;           ///< mean LDR-FLIP of the pictures clamped to [0,1] [Andersson2020]
  double hdr_flip = 0;       ///< mean HDR-FLIP [Andersson2021]
  double bias = 0;           ///< mean luminance of test − reference
  Interval bias_interval;    ///< of `bias`, with `bias_level`
  double relative_bias = 0;  ///< bias / mean luminance of the reference; 0 when that is 0
  Interval relative_bias_interval;
  double bias_level = 0.95;
  bool bias_from_errors = false;      ///< interval from StdErr channels (else from the spread of pixel differences)
  std::uint64_t non_finite_test = 0;  ///< pixels with a NaN or infinite component
  std::uint64_t non_finite_reference = 0;
};

/// Largest pictures that FLIP and HDR-FLIP are computed of without being asked for.
inline constexpr std::uint64_t kMostFlipPixels = std::uint64_t{1} << 24;
inline constexpr std::uint64_t kMostHdrFlipPixels = std::uint64_t{1} << 21;

struct MetricOptions {
  bool flip = true;                          ///< NaN when left out
  bool hdr_flip = true;                      ///< some ten times as long as FLIP; NaN when left out
  double pixels_per_degree = 67.0206432766;  ///< 0.7 m from a 0.7 m wide screen of 3840 pixels, the papers' default
  double bias_level = 0.95;                  ///< of the interval
};
Metrics compute_metrics(const Image& test, const Image& reference, const MetricOptions& options = {});

/// Structural similarity of two single-channel pictures with range 1: Gaussian window 11 × 11, σ 1.5, K1 0.01, K2 0.03;
/// mean over the windows that fit; where the picture is smaller than a window, over all windows cut off at its border.
double ssim(const std::vector<double>& a, const std::vector<double>& b, std::uint32_t width, std::uint32_t height);

/// ssim of the luma of the display values.
double mean_ssim(const Image& test, const Image& reference);

/// Error map of LDR-FLIP in [0,1]; colours are linear and clamped to [0,1] first.
std::vector<float> ldr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference,
                            std::uint32_t width, std::uint32_t height, double pixels_per_degree);

/// Its mean, in memory that does not grow with the picture.
double mean_ldr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference, std::uint32_t width,
                     std::uint32_t height, double pixels_per_degree);

/// The exposures HDR-FLIP looks at: from the one that brings the reference's brightest pixel to 0.85 after the ACES
/// tone curve to the one that does so for its median, ⌈difference⌉ steps, at least 2.
std::vector<double> hdr_flip_exposures(const std::vector<glm::vec3>& reference);
/// Error map of HDR-FLIP: the largest LDR-FLIP over the exposures, pixel by pixel.
std::vector<float> hdr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference,
                            std::uint32_t width, std::uint32_t height, double pixels_per_degree);

/// Its mean, in memory that does not grow with the picture.
double mean_hdr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference, std::uint32_t width,
                     std::uint32_t height, double pixels_per_degree);

/// Steps of FLIP, exposed so that each can be checked against the paper.
namespace flip {
/// Linear RGB → YCxCz, the linearised L*a*b* with the white of Rec. 709.
glm::dvec3 ycxcz_from_rgb(const glm::dvec3& rgb);
glm::dvec3 rgb_from_ycxcz(const glm::dvec3& ycxcz);
/// Linear RGB → CIE L*a*b*, chroma then scaled by 0.01 L (Hunt effect).
glm::dvec3 hunt_lab_from_rgb(const glm::dvec3& rgb);
/// |ΔL| + √(Δa² + Δb²) [Abasi2020].
double hyab(const glm::dvec3& a, const glm::dvec3& b);
/// HyAB distance to the power 0.7, compressed to [0,1].
double redistribute(double hyab_distance);
/// ACES fit of Narkowicz with the scale 0.6 of the paper, one channel.
double tone_map(double x);
}  // namespace flip

}  // namespace etendue
