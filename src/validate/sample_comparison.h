#pragma once
/// L2 of the equality contract: two renderers, the same random numbers, sample by sample. Each sample either took the
/// same decisions (equal signatures) and agrees to rounding, or is a counted branch flip; any other is named.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "render/renderer.h"
#include "validate/statistics.h"

namespace etendue {

/// Bounds of "rounding only". They are engineering bounds, not tests: float32 against double gives a median near 10⁻⁶
/// and, where a path amplifies rounding (glass, grazing light), a few samples beyond 10⁻³; edges flip some tens of
/// paths in a million.
struct SampleLimits {
  double median_error = 1e-4;       ///< of samples that did not flip
  double off_error = 1e-2;          ///< relative error beyond which a sample is "off"
  double off_per_million = 1000;    ///< samples off without a flip
  double flips_per_million = 2000;  ///< samples whose decisions differ
  double paired_level = 1e-3;       ///< false-alarm rate of the paired test of the means
};

/// The vertex where two traces of one sample diverge.
struct Divergence {
  SampleId id;
  std::uint32_t bounce = 0;  ///< index of the first vertex that differs, 0 = first hit
  std::string what;          ///< field that differs there: "instance", "lobe", "radiance", …; empty: the traces agree
  std::string device, reference;  ///< its values
  double relative_error = 0;      ///< of the whole sample
  glm::vec3 device_radiance{0.0f}, reference_radiance{0.0f};
};

struct WorstPixel {
  std::uint32_t pixel = 0;
  std::uint32_t flips = 0;
  double largest_error = 0;  ///< of its samples that did not flip
};

struct SampleComparison {
  std::uint64_t samples = 0;
  std::uint64_t equal_bits = 0;  ///< same signature and the same three floats
  std::uint64_t flips = 0;
  std::uint64_t off = 0;                                   ///< not flipped, error beyond SampleLimits::off_error
  std::uint64_t non_finite = 0;                            ///< NaN or infinite on one side only, or on both
  double median_error = 0, p999_error = 0, max_error = 0;  ///< relative, of samples that did not flip
  TTestResult paired;               ///< mean luminance, device against reference, with the variance of the differences
  std::vector<WorstPixel> worst;    ///< at most 8, by error, then by flips
  std::vector<Divergence> located;  ///< worst sample first, then up to 32 that differ visibly, then up to 32 flips
  std::map<std::string, std::uint32_t> first_differences;  ///< "bounce 1: radiance" → number among the located
  SampleLimits limits;
  double flips_per_million() const {
    return samples == 0 ? 0.0 : 1e6 * static_cast<double>(flips) / static_cast<double>(samples);
  }
  double off_per_million() const {
    return samples == 0 ? 0.0 : 1e6 * static_cast<double>(off) / static_cast<double>(samples);
  }
  bool identical() const { return samples > 0 && equal_bits == samples; }
  /// Within all limits.
  bool rounding_only() const;
  /// The means agree by the paired test and every sample is finite.
  bool same_mean() const { return non_finite == 0 && paired.p_value >= limits.paired_level; }
};

/// The results of single samples.
struct TracedSamples {
  std::vector<SampleId> ids;
  std::vector<SampleRecord> records;
};

/// Traces about `budget` samples: all pixels when the budget allows, else a low-discrepancy choice of them. The choice
/// depends on the arguments alone.
TracedSamples trace_some(Renderer& renderer, std::uint32_t width, std::uint32_t height, std::uint64_t budget);

/// Both have traced the same samples with the settings that they still have: some are retraced.
SampleComparison compare_samples(Renderer& device, const TracedSamples& by_device, Renderer& reference,
                                 const TracedSamples& by_reference, const SampleLimits& limits = {});

/// Traces about `budget` samples of both, and compares them.
SampleComparison compare_samples(Renderer& device, Renderer& reference, std::uint32_t width, std::uint32_t height,
                                 std::uint64_t budget, const SampleLimits& limits = {});

/// Retraces one sample on both sides and finds where they part.
Divergence locate_divergence(Renderer& device, Renderer& reference, SampleId id);

}  // namespace etendue
