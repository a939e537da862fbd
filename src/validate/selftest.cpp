#include "validate/selftest.h"
#include "scene/test_patch.h"

#include <algorithm>
#include <chrono>
#include <random>

#include <fmt/format.h>

#include "image/film.h"
#include "validate/chi2.h"

namespace etendue {
namespace {

constexpr double kOverallLevel = 1e-3;

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// About the level of one test of a suite; exact where all of them are decided by a distribution.
double test_level(const SelftestOptions& options) {
  return sidak_level(options.significance, kSceneFamilies.size() + 2);
}

SelftestCase scene_case(const RendererFactory& make_renderer, SceneFamily family, std::uint64_t seed,
                        const SelftestOptions& options) {
  const Stopwatch watch;
  const ClosedFormScene scene = make_closed_form(family, seed);
  std::uint64_t rejected = 0;
  const TTestResult t =
      measure_scene(make_renderer, scene, static_cast<std::uint32_t>(seed), options.samples, rejected);
  SelftestCase result{.seed = seed, .family = scene_family_name(family), .name = scene.name, .result = {}};
  result.p_value = rejected > 0 ? 0.0 : t.p_value;
  result.statistical = rejected == 0 && t.decision == Decision::statistical;
  result.tested = rejected > 0 || is_conclusive(t, test_level(options));
  result.result = fmt::format("{:.7g} ± {:.3g}, expected {:.7g}", t.mean, t.standard_error, t.reference);
  if (rejected > 0) result.result += fmt::format(", {} samples not finite", rejected);
  result.seconds = watch.seconds();
  return result;
}

/// A material of random parameters at a random direction.
SelftestCase material_case(const BsdfProbeFactory& make_probe, bool dielectric, std::uint64_t seed,
                           const SelftestOptions& options) {
  const Stopwatch watch;
  std::mt19937_64 engine(2 * seed + dielectric);
  const auto unit = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  Chi2Test settings;
  settings.test_count = 1;
  settings.significance_level = 0.5;  // the verdict is the suite's
  settings.bsdfs.push_back(
      {.patch = test_patch(DiffuseBsdf{{unit(), unit(), unit()}}), .name = "diffuse", .position = {}});
  if (dielectric)
    settings.bsdfs[0] = {
        .patch = test_patch(DielectricBsdf{1.0 + unit(), 1.0 + unit()}), .name = "dielectric", .position = {}};
  const BsdfChi2 test =
      run_chi2(settings, "", make_probe,
               {.seed = static_cast<std::uint32_t>(seed), .significance_level = {}, .sample_count = options.samples})
          .tests.front();
  SelftestCase result{.seed = seed, .family = "chi2", .name = test.name, .result = {}};
  result.statistical = test.fault.empty() && test.test.cells > 1;
  result.p_value = test.fault.empty() ? test.test.p_value : 0.0;
  result.tested = test.tested;
  result.result =
      test.fault.empty() ? fmt::format("chi2 {:.5g}, {} cells", test.test.statistic, test.test.cells) : test.fault;
  result.seconds = watch.seconds();
  return result;
}

/// Judges the cases of one suite; true when none failed.
bool judge_suite(std::span<SelftestCase> cases, double significance) {
  const auto statistical =
      std::count_if(cases.begin(), cases.end(), [](const SelftestCase& c) { return c.tested && c.statistical; });
  const double level = sidak_level(significance, static_cast<std::uint64_t>(statistical));
  bool passed = true;
  for (SelftestCase& c : cases) {
    if (!c.tested) continue;
    c.passed = c.statistical ? c.p_value >= level : c.p_value == 1.0;
    passed = passed && c.passed;
  }
  return passed;
}

void take_device(const RendererFactory& make_renderer, SelftestReport& report) {
  const auto renderer = make_renderer(make_closed_form(SceneFamily::coverage, 0).scene, {});
  report.device = renderer->device_name();
  report.driver = renderer->driver_name();
}

}  // namespace

bool SelftestReport::passed() const {
  if (untested > 0 && !options.allow_untested) return false;
  if (options.seeds == 1) return failed_suites == 0;
  const bool within_tolerance = std::all_of(
      cases.begin(), cases.end(), [](const SelftestCase& c) { return c.statistical || !c.tested || c.passed; });
  return within_tolerance && suites_p >= kOverallLevel && smallest_p >= kOverallLevel;
}

TTestResult measure_scene(const RendererFactory& make_renderer, const ClosedFormScene& scene, std::uint32_t seed,
                          std::uint64_t samples, std::uint64_t& rejected) {
  const auto renderer = make_renderer(scene.scene, {seed, FilmQuantity::luminance});
  const Camera& camera = scene.scene.camera;
  const std::uint64_t pixels = std::uint64_t{camera.width} * camera.height;
  Film film(camera.width, camera.height, film_exponent(scene.scene));
  std::vector<RejectedSample> located;
  const std::uint64_t sets = scene.scene.sampler.sets_of((samples + pixels - 1) / pixels);
  renderer->render({0, static_cast<std::uint32_t>(std::max<std::uint64_t>(2, sets))}, film, {}, located);
  rejected = film.rejected();
  const Moments m = film_moments(film, 0);
  if (m.n < 2) return {.reference = scene.expected};  // all rejected: p is 0
  return t_test(static_cast<double>(m.mean), static_cast<double>(m.variance), m.n, scene.expected);
}

SelftestReport run_selftest(const RendererFactory& make_renderer, const BsdfProbeFactory& make_probe,
                            const SelftestOptions& options) {
  SelftestReport report;
  report.options = options;
  take_device(make_renderer, report);
  std::uint64_t statistical = 0;
  for (std::uint32_t i = 0; i < options.seeds; ++i) {
    const std::uint64_t seed = options.seed + i;
    const std::size_t first = report.cases.size();
    for (const SceneFamily family : kSceneFamilies)
      report.cases.push_back(scene_case(make_renderer, family, seed, options));
    for (const bool dielectric : {false, true})
      report.cases.push_back(material_case(make_probe, dielectric, seed, options));
    report.failed_suites += !judge_suite(std::span(report.cases).subspan(first), options.significance);
    if (options.progress) options.progress(i + 1);
  }
  for (const SelftestCase& c : report.cases) {
    report.untested += !c.tested;
    if (!c.tested || !c.statistical) continue;
    ++statistical;
    report.smallest_p = std::min(report.smallest_p, c.p_value);
  }
  report.smallest_p = sidak_adjust(report.smallest_p, statistical);
  report.suites_p = binomial_upper_tail(report.failed_suites, options.seeds, options.significance);
  return report;
}

std::string selftest_text(const SelftestReport& report) {
  std::string out = fmt::format("selftest on {} ({}), seed {}, {} suite(s), {} samples a test\n", report.device,
                                report.driver, report.options.seed, report.options.seeds, report.options.samples);
  out += fmt::format("{:<12} {:>6} {:>12} {:>11} {:>7} {:>12}\n", "family", "tests", "statistical", "not tested",
                     "failed", "smallest p");
  std::vector<std::string> families;
  families.reserve(kSceneFamilies.size() + 1);
  for (const SceneFamily family : kSceneFamilies) families.emplace_back(scene_family_name(family));
  families.emplace_back("chi2");
  for (const std::string& family : families) {
    std::uint64_t tests = 0, statistical = 0, untested = 0, failed = 0;
    double smallest = 1.0;
    for (const SelftestCase& c : report.cases) {
      if (c.family != family) continue;
      ++tests;
      statistical += c.tested && c.statistical;
      untested += !c.tested;
      failed += c.tested && !c.passed;
      if (c.tested && c.statistical) smallest = std::min(smallest, c.p_value);
    }
    out += fmt::format("{:<12} {:>6} {:>12} {:>11} {:>7} {:>12.4g}\n", family, tests, statistical, untested, failed,
                       smallest);
  }
  for (const SelftestCase& c : report.cases) {
    if (!c.tested) {
      out += fmt::format("not tested: seed {}, {}: {}; raise --samples\n", c.seed, c.name, c.result);
    } else if (!c.passed) {
      out += fmt::format("failed: seed {}, {}: {}; p = {:.3g}\n", c.seed, c.name, c.result, c.p_value);
    }
  }
  const double rate = static_cast<double>(report.failed_suites) / report.options.seeds;
  const Interval interval = binomial_interval(report.failed_suites, report.options.seeds, 0.95);
  out += fmt::format(
      "{}: {} of {} suites failed ({:.3g}, 95 % interval {:.3g} to {:.3g}){}; false-alarm rate of a suite {:g}\n",
      report.passed() ? "passed" : "FAILED", report.failed_suites, report.options.seeds, rate, interval.low,
      interval.high, report.untested > 0 ? fmt::format(", {} tests could not be made", report.untested) : "",
      report.options.significance);
  return out;
}

Json selftest_json(const SelftestReport& report) {
  Json cases = Json::array();
  for (const SelftestCase& c : report.cases) {
    cases.push_back({{"seed", c.seed},
                     {"family", c.family},
                     {"name", c.name},
                     {"result", c.result},
                     {"p", c.p_value},
                     {"decidedBy", c.statistical ? "distribution" : "tolerance"},
                     {"seconds", c.seconds},
                     {"tested", c.tested},
                     {"passed", c.passed}});
  }
  return {{"device", report.device},
          {"driver", report.driver},
          {"seed", report.options.seed},
          {"suites", report.options.seeds},
          {"samples", report.options.samples},
          {"significance", report.options.significance},
          {"failedSuites", report.failed_suites},
          {"untested", report.untested},
          {"suitesP", report.suites_p},
          {"smallestP", report.smallest_p},
          {"cases", cases},
          {"passed", report.passed()}};
}

std::vector<JunitCase> selftest_junit(const SelftestReport& report) {
  std::vector<JunitCase> cases;
  if (report.options.seeds > 1) {  // single cases may fail by chance then: the verdict is that of all suites
    return {
        {.name = fmt::format("{} suites from seed {}", report.options.seeds, report.options.seed),
         .failed = !report.passed(),
         .message = fmt::format("{} suites failed, {} tests could not be made", report.failed_suites, report.untested),
         .details = selftest_text(report)}};
  }
  for (const SelftestCase& c : report.cases) {
    cases.push_back({.name = fmt::format("{}: {}, seed {}", c.family, c.name, c.seed),
                     .seconds = c.seconds,
                     .failed = c.tested ? !c.passed : !report.options.allow_untested,
                     .skipped = !c.tested && report.options.allow_untested,
                     .message = c.tested ? fmt::format("{}; p = {:.3g}", c.result, c.p_value)
                                         : fmt::format("not tested: {}", c.result),
                     .details = fmt::format("{}; p = {:.5g}", c.result, c.p_value)});
  }
  return cases;
}

}  // namespace etendue
