#pragma once
/// `etendue validate`: does this device render the right image? The device against the reference by the equality
/// contract of docs/validation.md, in one verdict.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "validate/compare.h"
#include "validate/renderer_factory.h"
#include "validate/sample_comparison.h"

namespace etendue {

struct ValidateOptions {
  /// L2 uses it on all sides; L3 uses seed + 1 (first device), seed + 2 (reference), seed + 3 (second device), …
  std::uint32_t seed = 0;
  std::uint32_t samples_per_pixel = 0;    ///< of L3; 0: the scene's, between 16 and 64
  std::uint64_t sample_budget = 1 << 18;  ///< samples compared one by one
  double significance = 0.01;             ///< false-alarm rate of L3, of all pairs together
  SampleLimits limits;
  /// Makes a reference that is shaken by rounding (make_shaken_reference_renderer): how far samples part in this scene
  /// for that reason alone. Asked when a device parts farther than `limits` say, which it may raise. None: they stand.
  RendererFactory make_shaken;
  Verdict worst_accepted = Verdict::statistically_equal;  ///< or rounding_only, or identical
  bool allow_untested = false;                            ///< a validation that could not be made passes
  Progress progress;                                      ///< of the two L3 renders; may stop them (Error(interrupted))
};

/// One device against the reference, or against another device, which then stands where the reference does.
struct Validation {
  std::string scene;
  std::string device_label, reference_label;  ///< as in DevicesValidation
  std::string device, device_driver, reference, reference_driver;
  std::uint32_t seed = 0, samples_per_pixel = 0;
  std::uint32_t device_seed = 0, reference_seed = 0;  ///< of L3
  SampleComparison samples;                           ///< L2
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

/// Several devices, pair by pair.
struct DevicesValidation {
  struct Entrant {
    std::string label, device, driver;
  };
  std::string scene;
  std::uint32_t seed = 0, samples_per_pixel = 0;
  std::uint64_t samples = 0;      ///< of L2
  double significance = 0;        ///< of all pairs together
  std::vector<Entrant> entrants;  ///< the devices, then the reference
  std::vector<Validation> pairs;  ///< each device against the reference, then each against those before it
  /// The verdict of the worst pair: different first, then untested, then the others.
  Verdict verdict() const;
  bool passed() const;
};

/// Each device against the reference and against each other, as by validate_scene. Every device renders once, whatever
/// the number of pairs. Two devices may be apart by the sum of what each may be from the reference. The levels of the
/// tests are Šidák's for the number of pairs.
DevicesValidation validate_devices(const Scene& scene, const std::vector<LabelledFactory>& devices,
                                   const RendererFactory& make_reference, const ValidateOptions& options = {});

/// A table of one row a pair, and whatever did not pass at length.
std::string devices_text(const DevicesValidation& validation);
Json devices_json(const DevicesValidation& validation);

std::string validation_text(const Validation& validation);
Json validation_json(const Validation& validation);
JunitCase validation_junit(const Validation& validation);

}  // namespace etendue
