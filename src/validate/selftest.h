#pragma once
/// `etendue selftest`: fresh scenes with a known answer and fresh materials, one suite per seed.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/json.h"
#include "render/bsdf_probe.h"
#include "validate/closed_form.h"
#include "validate/junit.h"
#include "validate/renderer_factory.h"
#include "validate/statistics.h"

namespace etendue {

struct SelftestOptions {
  std::uint64_t seed = 0;                            ///< of the first suite; suite i has seed + i
  std::uint32_t seeds = 1;                           ///< number of suites
  std::uint64_t samples = 65536;                     ///< of each test
  double significance = 0.01;                        ///< probability that a suite fails without an error
  bool allow_untested = false;                       ///< tests that say nothing do no harm
  std::function<void(std::uint32_t done)> progress;  ///< called after each suite, if set
};

struct SelftestCase {
  std::uint64_t seed = 0;
  std::string family;  ///< that of a scene, or "chi2"
  std::string name;
  std::string result;  ///< the numbers, for a person
  double p_value = 0;
  bool statistical = true;  ///< false: decided by a numerical tolerance, p is 0 or 1
  bool tested = true;       ///< false: too few samples for the test to say anything; it has neither passed nor failed
  bool passed = false;
  double seconds = 0;
};

struct SelftestReport {
  std::string device, driver;
  SelftestOptions options;
  std::vector<SelftestCase> cases;
  std::uint32_t failed_suites = 0;
  std::uint64_t untested = 0;  ///< cases
  double suites_p = 1;         ///< P(at least so many suites fail without an error)
  double smallest_p = 1;       ///< of all cases together (Šidák)
  /// One suite: it passed. Several: no more failed than chance explains (0.001), no case is beyond chance (0.001 over
  /// all), and none failed its numerical tolerance. In either case every test was made, unless allow_untested.
  bool passed() const;
};

/// Throws what the factories throw.
SelftestReport run_selftest(const RendererFactory& make_renderer, const BsdfProbeFactory& make_probe,
                            const SelftestOptions& options = {});

/// Mean luminance of `samples` samples of the scene's film against what is expected; `rejected` counts samples that are
/// not finite.
TTestResult measure_scene(const RendererFactory& make_renderer, const ClosedFormScene& scene, std::uint32_t seed,
                          std::uint64_t samples, std::uint64_t& rejected);

std::string selftest_text(const SelftestReport& report);
Json selftest_json(const SelftestReport& report);
std::vector<JunitCase> selftest_junit(const SelftestReport& report);

}  // namespace etendue
