#include "validate/ttest.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "image/film.h"
#include "image/vectors.h"

namespace etendue {
namespace {

/// Film samples of a pixel, which are sets of paths, so that the film gets at least `count` paths in all, and at least
/// the two sets a variance needs. Sets are independent, as a t-test demands; the paths of a set are not.
std::uint32_t sets_per_pixel(const Scene& scene, std::uint64_t count) {
  const std::uint64_t pixels = std::uint64_t{scene.camera.width} * scene.camera.height;
  const std::uint64_t sets =
      std::max<std::uint64_t>(scene.sampler.sets_of((count + pixels - 1) / pixels), (2 + pixels - 1) / pixels);
  if (sets * scene.sampler.set_size() > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorKind::usage,
                fmt::format("sampleCount {} over {} pixel(s) is more than 2^32 − 1 samples per pixel", count, pixels));
  }
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(sets, 1));
}

/// Luminance of at most `limit` of the film's samples, evenly over pixels and sample indices.
std::vector<double> single_samples(Renderer& renderer, std::uint64_t pixels, std::uint64_t spp, std::uint64_t limit) {
  const std::uint64_t n = std::min(limit, pixels * spp);
  std::vector<SampleId> ids;
  ids.reserve(n);
  for (std::uint64_t i = 0; i < n; ++i) {
    const std::uint64_t flat =
        n == pixels * spp ? i
                          : static_cast<std::uint64_t>(static_cast<double>(i) * static_cast<double>(pixels * spp) /
                                                       static_cast<double>(n));
    ids.push_back({static_cast<std::uint32_t>(flat / spp), static_cast<std::uint32_t>(flat % spp)});
  }
  std::vector<double> values;
  values.reserve(n);
  for (const SampleRecord& record : renderer.trace_samples(ids)) {
    if (const double y = luminance(record.radiance); std::isfinite(y)) values.push_back(y);
  }
  return values;
}

SceneTTest test_scene(const Scene& scene, double reference, std::uint32_t seed, std::uint64_t sample_count,
                      std::uint64_t tail_samples, const RendererFactory& make_renderer, TTestReport& report) {
  const auto start = std::chrono::steady_clock::now();
  const std::unique_ptr<Renderer> renderer = make_renderer(scene, {seed, FilmQuantity::luminance});
  report.device = renderer->device_name();
  report.driver = renderer->driver_name();

  SceneTTest result;
  result.width = scene.camera.width;
  result.height = scene.camera.height;
  const std::uint32_t sets = sets_per_pixel(scene, sample_count);
  const std::uint64_t spp = std::uint64_t{sets} * scene.sampler.set_size();
  result.samples_per_pixel = spp;
  Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
  renderer->render({0, sets}, film, {}, result.located);
  result.rejected = film.rejected();
  const Moments m = film_moments(film, 0);
  if (m.n >= 2) {
    result.test = t_test(static_cast<double>(m.mean), static_cast<double>(m.variance), m.n, reference);
  } else {
    result.test.reference = reference;  // every sample was rejected: p stays 0
    result.test.n = m.n;
  }
  if (tail_samples > 0) {
    const std::uint64_t pixels = std::uint64_t{scene.camera.width} * scene.camera.height;
    result.tail = tail_report(single_samples(*renderer, pixels, spp, tail_samples));
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

/// The text in the last column.
std::string verdict_of(const SceneTTest& scene) {
  if (!scene.tested) return scene.passed ? "not tested, allowed" : "NOT TESTED";
  return scene.passed ? "passed" : "FAILED";
}

std::string untested_note(const SceneTTest& s, double level) {
  if (s.test.n < 2)
    return fmt::format("not tested: {} sample(s) have no variance; raise the number of samples", s.test.n);
  return fmt::format(
      "not tested: with {} samples of this noise a mean off by up to {:.3g} (mean {:.4g}, reference {:.4g}) would go "
      "unnoticed; raise the number of samples",
      s.test.n, detectable_difference(s.test, level), s.test.mean, s.test.reference);
}

std::string tail_note(const TailReport& tail) {
  return fmt::format(
      "heavy tail: the largest of {} samples ({:.4g}, mean {:.4g}) makes {:.1f} % of the variance, Hill index "
      "{:.2f} ± {:.2f} (below 2 the variance is infinite); this p-value is not reliable",
      tail.n, tail.largest, tail.mean, 100.0 * tail.largest_share, tail.hill_index, tail.hill_error);
}

std::string rejected_note(const SceneTTest& scene) {
  std::string note = fmt::format("{} sample(s) were NaN, infinite or out of range", scene.rejected);
  if (!scene.located.empty()) {
    const RejectedSample& first = scene.located.front();
    note += fmt::format(", the first at pixel ({}, {}), sample {}, segment {}", first.id.pixel % scene.width,
                        first.id.pixel / scene.width, first.id.sample, first.segments);
  }
  return note;
}

}  // namespace

void judge_ttest(SceneTTest& scene, double level, bool allow_untested) {
  scene.tested = scene.rejected > 0 || is_conclusive(scene.test, level);
  scene.passed = scene.rejected == 0 && (scene.tested ? scene.test.p_value >= level : allow_untested);
}

bool TTestReport::passed() const {
  return std::all_of(scenes.begin(), scenes.end(), [](const SceneTTest& s) { return s.passed; });
}

TTestReport run_ttest(const TTest& test, const std::string& file, const RendererFactory& make_renderer,
                      const TTestOptions& options) {
  if (test.references.size() != test.scenes.size() || test.scenes.empty()) {
    throw Error(ErrorKind::usage, fmt::format("{}: {} reference(s) for {} scene(s); each scene needs one reference",
                                              file, test.references.size(), test.scenes.size()));
  }
  TTestReport report;
  report.file = file;
  report.seed = options.seed;
  report.significance_level = options.significance_level.value_or(test.significance_level);
  report.test_level = sidak_level(report.significance_level, test.scenes.size());
  for (std::size_t i = 0; i < test.scenes.size(); ++i) {
    const Scene& scene = test.scenes[i];
    const std::uint64_t samples =
        options.samples_per_pixel ? std::uint64_t{*options.samples_per_pixel} * scene.camera.width * scene.camera.height
                                  : options.sample_count.value_or(test.sample_count);
    SceneTTest result = test_scene(scene, test.references[i], options.seed + static_cast<std::uint32_t>(i), samples,
                                   options.tail_samples, make_renderer, report);
    result.name = fmt::format("scene {}", i + 1);
    judge_ttest(result, report.test_level, options.allow_untested);
    report.scenes.push_back(std::move(result));
  }
  return report;
}

std::string ttest_table(const TTestReport& report) {
  std::string out = fmt::format("{} on {} ({}), seed {}\n", text::printable(report.file, text::kLongestLine),
                                report.device, report.driver, report.seed);
  out += fmt::format("{:<10} {:>10} {:>12} {:>12} {:>11} {:>9} {:>10}  verdict\n", "scene", "samples", "mean",
                     "reference", "std. error", "t", "p");
  for (const SceneTTest& s : report.scenes) {
    out += fmt::format("{:<10} {:>10} {:>12.7g} {:>12.7g} {:>11.3g} {:>9.4g} {:>10.4g}  {}{}\n", s.name, s.test.n,
                       s.test.mean, s.test.reference, s.test.standard_error, s.test.t, s.test.p_value, verdict_of(s),
                       s.test.decision == Decision::numerical
                           ? fmt::format(" (no variance: by tolerance {:.1g})", s.test.tolerance)
                           : "");
  }
  std::size_t passed = 0, untested = 0;
  for (const SceneTTest& s : report.scenes) {
    passed += s.passed && s.tested;
    untested += !s.tested;
    if (!s.tested) out += fmt::format("{}: {}\n", s.name, untested_note(s, report.test_level));
    if (s.rejected > 0) out += fmt::format("{}: {}\n", s.name, rejected_note(s));
    if (s.tail.heavy()) out += fmt::format("{}: {}\n", s.name, tail_note(s.tail));
  }
  out += fmt::format("{}: {} of {} passed{}; false-alarm rate of the file {:.4g}, of one scene {:.4g} (Šidák)\n",
                     report.passed() ? "passed" : "FAILED", passed, report.scenes.size(),
                     untested > 0 ? fmt::format(", {} not tested", untested) : "", report.significance_level,
                     report.test_level);
  return out;
}

Json ttest_json(const TTestReport& report) {
  Json scenes = Json::array();
  for (const SceneTTest& s : report.scenes) {
    scenes.push_back({{"name", s.name},
                      {"width", s.width},
                      {"height", s.height},
                      {"samplesPerPixel", s.samples_per_pixel},
                      {"samples", s.test.n},
                      {"mean", s.test.mean},
                      {"variance", s.test.variance},
                      {"standardError", s.test.standard_error},
                      {"reference", s.test.reference},
                      {"t", s.test.t},
                      {"degreesOfFreedom", s.test.dof},
                      {"p", s.test.p_value},
                      {"decidedBy", s.test.decision == Decision::numerical ? "tolerance" : "distribution"},
                      {"tolerance", s.test.tolerance},
                      {"rejected", s.rejected},
                      {"tail",
                       {{"samples", s.tail.n},
                        {"largest", s.tail.largest},
                        {"largestShare", s.tail.largest_share},
                        {"hillIndex", s.tail.hill_index},
                        {"hillError", s.tail.hill_error},
                        {"heavy", s.tail.heavy()}}},
                      {"seconds", s.seconds},
                      {"tested", s.tested},
                      {"passed", s.passed}});
  }
  return {{"file", report.file},
          {"device", report.device},
          {"driver", report.driver},
          {"seed", report.seed},
          {"significanceLevel", report.significance_level},
          {"testLevel", report.test_level},
          {"scenes", scenes},
          {"passed", report.passed()}};
}

std::vector<JunitCase> ttest_junit(const TTestReport& report) {
  std::vector<JunitCase> cases;
  for (const SceneTTest& s : report.scenes) {
    JunitCase c;
    c.name = report.file + ": " + s.name;
    c.seconds = s.seconds;
    c.failed = !s.passed;
    c.skipped = s.passed && !s.tested;
    c.message =
        s.rejected > 0 ? rejected_note(s)
        : !s.tested
            ? untested_note(s, report.test_level)
            : fmt::format("mean {:.7g} is {:.4g} standard errors from the reference {:.7g}, p = {:.3g} < {:.3g}",
                          s.test.mean, s.test.t, s.test.reference, s.test.p_value, report.test_level);
    c.details = fmt::format("n = {}, mean = {:.9g}, reference = {:.9g}, t = {:.5g}, p = {:.5g}{}", s.test.n,
                            s.test.mean, s.test.reference, s.test.t, s.test.p_value,
                            s.tail.heavy() ? fmt::format("\n{}", tail_note(s.tail)) : std::string());
    cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace etendue
