#pragma once
/// `etendue compare`: how far apart two pictures are, and whether chance explains it.

#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "image/image.h"
#include "validate/image_tests.h"
#include "validate/junit.h"
#include "validate/metrics.h"

namespace etendue {

/// The verdict of a comparison.
enum class Verdict {
  identical,            ///< every value equal
  rounding_only,        ///< the same decisions, values apart by rounding (validate)
  statistically_equal,  ///< chance explains the differences
  different,            ///< it does not
  untested,             ///< nothing, or too little, to judge by: only distances
};
const char* verdict_name(Verdict verdict);

/// A bound that a metric must keep: "flip=0.05" (not above) or "ssim=0.98" (not below).
struct Limit {
  std::string metric;
  double value = 0;
  bool upper = true;
};
/// Names: mse rmse relmse mae flip hdrflip bias relbias nonfinite (upper limits; bias and relbias without sign), psnr
/// ssim (lower limits). Throws Error(usage) for an unknown name, a number that is none, or the wrong side.
Limit parse_limit(const std::string& text, bool upper);

struct CompareOptions {
  double significance = 0.01;  ///< false-alarm rate of all statistical tests together
  MetricOptions metrics;
  std::vector<Limit> limits;
  bool allow_untested = false;  ///< a comparison that could not be tested passes
};

struct LimitOutcome {
  Limit limit;
  double value = 0;
  bool kept = false;
};

struct MetadataDifference {
  std::string name, test, reference;  ///< "" = absent
};

struct Comparison {
  std::string test_name, reference_name;
  std::uint32_t width = 0, height = 0;
  Metrics metrics;
  std::optional<ImageTests> tests;  ///< when both pictures carry standard errors
  std::vector<LimitOutcome> limits;
  std::vector<MetadataDifference> metadata;
  std::vector<std::string> notes;
  Verdict verdict = Verdict::untested;
  std::string untested_why;     ///< one sentence when the verdict is untested
  bool allow_untested = false;  ///< as in CompareOptions
  /// Neither different nor beyond a limit; and tested, or judged by limits instead, or allow_untested.
  bool passed() const;
};

/// Compares `test` with `reference`. Throws Error(usage) when they cannot be compared.
Comparison compare_images(const Image& test, const std::string& test_name, const Image& reference,
                          const std::string& reference_name, const CompareOptions& options = {});

std::string comparison_text(const Comparison& comparison);
Json comparison_json(const Comparison& comparison);
JunitCase comparison_junit(const Comparison& comparison);
/// Indented text of a JSON value; infinity and NaN become null, invalid UTF-8 U+FFFD.
std::string json_text(const Json& json);
/// The parts shared with the validate report.
std::string image_tests_text(const ImageTests& tests);
Json image_tests_json(const ImageTests& tests);
std::vector<MetadataDifference> metadata_differences(const Metadata& test, const Metadata& reference);

}  // namespace etendue
