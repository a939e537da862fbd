#pragma once
/// `etendue ttest`: the mean luminance of each scene of a test file against its reference.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "scene/scene_file.h"
#include "validate/junit.h"
#include "validate/renderer_factory.h"
#include "validate/statistics.h"

namespace etendue {

struct TTestOptions {
  std::uint32_t seed = 0;                     ///< scene i is rendered with seed + i, so that the tests are independent
  std::optional<double> significance_level;   ///< instead of the file's, in (0,1)
  std::optional<std::uint64_t> sample_count;  ///< instead of the file's
  std::optional<std::uint32_t> samples_per_pixel;  ///< instead of either, times the pixels of a scene
  std::uint64_t tail_samples = 65536;              ///< samples looked at one by one for the tail report; 0 = none
  bool allow_untested = false;                     ///< a test that says nothing passes
};

struct SceneTTest {
  std::string name;  ///< "scene 3" or the scene's own name
  std::uint32_t width = 0, height = 0;
  std::uint64_t samples_per_pixel = 0;
  TTestResult test;  ///< n = film samples that counted: paths, or sets of paths (Sampler::set_size)
  TailReport tail;
  std::uint64_t rejected = 0;           ///< NaN, infinite or out-of-range samples: any is a failure
  std::vector<RejectedSample> located;  ///< the first of them
  double seconds = 0;
  bool tested = false;  ///< false: too few samples, or too much noise, for the test to say anything (is_conclusive)
  bool passed = false;  ///< untested ones only where that is allowed
};

/// Fills in `tested` and `passed`.
void judge_ttest(SceneTTest& scene, double level, bool allow_untested);

struct TTestReport {
  std::string file;
  std::string device, driver;
  std::uint32_t seed = 0;
  double significance_level = 0;  ///< of the whole file: probability that it fails without an error
  double test_level = 0;          ///< of one scene, after Šidák
  std::vector<SceneTTest> scenes;
  bool passed() const;
};

/// Renders `sampleCount` paths of each scene, spread evenly over its film (rounded up to whole samples per
/// pixel), and tests their mean luminance. Over more than one pixel the variance includes that between pixels, which
/// makes the test conservative. A test that is not conclusive is no pass. Throws Error(usage) when references and
/// scenes differ in number, or whatever the renderer throws.
TTestReport run_ttest(const TTest& test, const std::string& file, const RendererFactory& make_renderer,
                      const TTestOptions& options = {});

/// Lines for a person: a table, notes on heavy tails and rejected samples, the verdict.
std::string ttest_table(const TTestReport& report);
Json ttest_json(const TTestReport& report);
std::vector<JunitCase> ttest_junit(const TTestReport& report);

}  // namespace etendue
