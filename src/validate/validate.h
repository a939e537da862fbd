#pragma once
/// `etendue validate`: does this device render the right image? The device against the reference by the equality
/// contract of docs/validation.md, in one verdict.

#include <cstdint>
#include <optional>
#include <string>

#include "core/json.h"
#include "validate/compare.h"
#include "validate/renderer_factory.h"
#include "validate/sample_comparison.h"

namespace etendue {

struct ValidateOptions {
  std::uint32_t seed = 0;  ///< L2 uses it on both sides; L3 uses seed + 1 (device) and seed + 2 (reference)
  std::uint32_t samples_per_pixel = 0;    ///< of L3; 0: the scene's, between 16 and 64
  std::uint64_t sample_budget = 1 << 18;  ///< samples compared one by one
  double significance = 0.01;             ///< false-alarm rate of L3
  SampleLimits limits;
  /// Makes a reference that is shaken by rounding (make_shaken_reference_renderer): how far samples part in this scene
  /// for that reason alone. Asked when a device parts farther than `limits` say, which it may raise. None: they stand.
  RendererFactory make_shaken;
  Verdict worst_accepted = Verdict::statistically_equal;  ///< or rounding_only, or identical
  bool allow_untested = false;                            ///< a validation that could not be made passes
  Progress progress;                                      ///< of the two L3 renders; may stop them (Error(interrupted))
};

struct Validation {
  std::string scene;
  std::string device, device_driver, reference, reference_driver;
  std::uint32_t seed = 0, samples_per_pixel = 0;
  SampleComparison samples;                  ///< L2
  std::optional<SampleComparison> rounding;  ///< of the shaken reference with the reference, where it was asked
  ImageTests tests;                          ///< L3
  std::uint64_t device_rejected = 0, reference_rejected = 0;
  std::vector<RejectedSample> rejected;
  Image device_image, reference_image;  ///< of L3, independent seeds
  Verdict verdict = Verdict::untested;
  Verdict worst_accepted = Verdict::statistically_equal;
  std::string untested_why;  ///< one sentence when the verdict is untested
  bool allow_untested = false;
  /// The verdict is at least as good as accepted, or untested where that is allowed.
  bool passed() const {
    if (verdict == Verdict::untested) return allow_untested;
    return static_cast<int>(verdict) <= static_cast<int>(worst_accepted);
  }
};

/// Identical: every sample of L2 equal to the bit. Rounding only: L2 within its limits. Statistically equal: neither,
/// but the means of L2 and all tests of L3 agree. Different: a test rejects, or a sample is not finite. Untested: the
/// tests of L3 could not be made (ImageTests::made), or L2 has fewer than two samples. L3 must pass in every case.
Validation validate_scene(const Scene& scene, const RendererFactory& make_device, const RendererFactory& make_reference,
                          const ValidateOptions& options = {});

std::string validation_text(const Validation& validation);
Json validation_json(const Validation& validation);
JunitCase validation_junit(const Validation& validation);

}  // namespace etendue
