/// `<test type="ttest">` with bsdfs: albedos at given angles.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/vectors.h"
#include "validate/chi2.h"
#include "validate/sphere_quadrature.h"

namespace etendue {
namespace {

constexpr std::uint32_t kChunk = 1u << 18;  // samples drawn at a time

SceneTTest test_albedo(BsdfProbe& probe, double angle, double reference, std::uint64_t count, std::uint32_t seed,
                       std::uint64_t tail_samples) {
  const auto start = std::chrono::steady_clock::now();
  const glm::dvec3 wo = spherical_direction(std::cos(angle * std::numbers::pi / 180.0), 0.0);
  RunningMoments moments;
  std::vector<double> looked_at;
  SceneTTest result;
  for (std::uint64_t done = 0; done < count; done += kChunk) {
    const auto n = static_cast<std::uint32_t>(std::min<std::uint64_t>(kChunk, count - done));
    for (const BsdfDraw& draw : probe.sample(wo, seed, static_cast<std::uint32_t>(done), n)) {
      const double y = draw.pdf == 0.0 ? 0.0 : luminance(draw.weight);
      if (!std::isfinite(y)) {
        ++result.rejected;
        continue;
      }
      moments.add(y);
      if (looked_at.size() < tail_samples) looked_at.push_back(y);
    }
  }
  result.width = result.height = 1;
  result.samples_per_pixel = count;
  result.test.reference = reference;
  result.test.n = moments.n();
  if (moments.n() >= 2) result.test = t_test(moments.mean(), moments.variance(), moments.n(), reference);
  result.tail = tail_report(looked_at);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

TTestReport run_bsdf_ttest(const TTest& test, const std::string& file, const BsdfProbeFactory& make_probe,
                           const TTestOptions& options) {
  const std::size_t tests = test.bsdfs.size() * test.angles.size();
  if (tests == 0 || test.references.size() != tests) {
    throw Error(ErrorKind::usage,
                fmt::format("{}: {} reference(s) for {} bsdf(s) at {} angle(s) each; each needs exactly one", file,
                            test.references.size(), test.bsdfs.size(), test.angles.size()));
  }
  TTestReport report;
  report.file = file;
  report.seed = options.seed;
  report.significance_level = options.significance_level.value_or(test.significance_level);
  report.test_level = sidak_level(report.significance_level, tests);
  const std::uint64_t count = std::max<std::uint64_t>(2, options.sample_count.value_or(test.sample_count));
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorKind::usage, fmt::format("{}: sampleCount {} is more than 2^32 − 1", file, count));
  for (const TestBsdf& bsdf : test.bsdfs) {
    const std::unique_ptr<BsdfProbe> probe = make_probe(bsdf.patch);
    report.device = probe->device_name();
    report.driver = probe->driver_name();
    for (const double angle : test.angles) {
      const std::size_t index = report.scenes.size();
      SceneTTest result = test_albedo(*probe, angle, test.references[index], count,
                                      options.seed + static_cast<std::uint32_t>(index), options.tail_samples);
      result.name = fmt::format("{}, {:g}°", bsdf.name, angle);
      judge_ttest(result, report.test_level, options.allow_untested);
      report.scenes.push_back(std::move(result));
    }
  }
  return report;
}

}  // namespace etendue
