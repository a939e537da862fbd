#include "validate/chi2.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "reference/bsdf.h"
#include "scene/materials.h"
#include "validate/sphere_quadrature.h"
#include "validate/test_leaves.h"

namespace etendue {
namespace {

using glm::dvec3;

/// Differences up to this are float32 rounding, whatever is compared.
constexpr double kRounding = 1e-4;
constexpr double kSharp = 0.01;  // roughness below which the rounding of a direction is felt by a lobe's density
constexpr double kCutOff =
    1e-4;  // samples in corners of the facets' cells that the horizon leaves and quadrature misses
constexpr double kStrays = 2.0;             // samples that may fall on a border where the density is 0, 1 in 10^7 does
constexpr std::uint32_t kChunk = 1u << 18;  // samples drawn at a time
constexpr std::size_t kContractSamples = 16384;  // samples whose pdf and weight are looked at one by one

double largest(const dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}
/// The larger of two errors; NaN is the largest.
double larger(double a, double b) {
  return std::isnan(b) ? std::numeric_limits<double>::infinity() : std::max(a, b);
}

/// The largest allowed deviation of a sample's density from that of its direction, which is rounded to single
/// precision.
double rounding_of(const Bsdf& bsdf) {
  const std::optional<Roughness> narrow = narrow_roughness(bsdf);
  double rounding = kRounding;
  if (narrow) rounding *= std::max(1.0, kSharp / std::min(narrow->alpha_u.value, narrow->alpha_v.value));
  // Near the critical angle Fresnel's factor is steep, and what is bent by little has a half vector of little length.
  return reference::traits(bsdf).transmissive ? std::max(rounding, 20.0 * kRounding) : rounding;
}

/// Whether a material, or one that its adapters may choose, scatters on both sides, or lets light pass.
bool has_two_sides(const Scene& patch) {
  bool two_sided = may_pass(patch);
  each_material(patch, patch.instances.front().material, [&](const Material& material) {
    two_sided = two_sided || (material.adapter ? std::holds_alternative<TwoSidedAdapter>(*material.adapter)
                                               : !reference::traits(material.bsdf).one_sided);
  });
  return two_sided;
}

/// Expectations in the order of the leaf's counts, as shares of the leaf's samples. Adds the leaf's part to the
/// integral, and fills in the fault when its own is more than 1.
std::vector<double> leaf_expectations(BsdfProbe& probe, const dvec3& wo, std::uint32_t seed, const TestLeaf& leaf,
                                      BsdfChi2& result) {
  std::vector<double> expected(leaf.counts.counts().size(), 0.0);
  expected.back() = 1.0;
  // Without an example it is so rare that no sample has chosen it.
  if (leaf.black || !leaf.example) return expected;
  const SphereDensity density = [&](std::span<const dvec3> directions) {
    std::vector<BsdfQuery> queries;
    for (const dvec3& wi : directions) queries.push_back({leaf.chosen.frame.to_world(wi), *leaf.example});
    std::vector<double> values;
    for (const BsdfValue& value : probe.evaluate(wo, seed, queries, BsdfProbe::Part::chosen))
      values.push_back(value.pdf);
    return values;
  };
  std::vector<double> cells = leaf.counts.grid().integrate(density);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i] == 0.0 && leaf.counts.counts()[i] > 0.0) cells[i] = leaf.counts.grid().integrate_finely(density, i);
  std::ranges::copy(cells, expected.begin());
  double total = std::accumulate(cells.begin(), cells.end(), 0.0);
  result.pdf_integral += leaf.probability * total;
  for (std::size_t i = 0; i < leaf.counts.lobes().size(); ++i) {
    expected[cells.size() + i] = leaf.counts.lobes()[i].prob;
    total += leaf.counts.lobes()[i].prob;
  }
  const double rounding = rounding_of(leaf.bsdf);
  if (!(total <= 1.0 + rounding)) result.fault = fmt::format("the density integrates to {:.6g}, more than 1", total);
  // The rest up to 1 is the probability of no direction. If it is below rounding, as many may be without as it
  // explains.
  const double drawn = leaf.probability * static_cast<double>(result.samples);
  const double rest = std::max(0.0, 1.0 - total), lost = leaf.counts.counts().back() / drawn;
  constexpr double kDeviations = 4.0;
  const bool explained = lost <= rest + kDeviations * std::sqrt(rest / drawn);
  expected.back() = rest > rounding ? rest : explained ? lost : 0.0;
  return expected;
}

/// The counts of all materials that may be chosen against their expectations.
ChiSquareResult test_counts(BsdfProbe& probe, const dvec3& wo, std::uint32_t seed, const TestLeaves& leaves,
                            const Chi2Test& settings, BsdfChi2& result) {
  std::vector<double> observed, expected;
  bool narrow = false;
  const auto samples = static_cast<double>(result.samples);
  for (const TestLeaf& leaf : leaves.leaves()) {
    narrow = narrow || leaf.counts.grid().narrow();
    observed.insert(observed.end(), leaf.counts.counts().begin(), leaf.counts.counts().end());
    for (const double share : leaf_expectations(probe, wo, seed, leaf, result))
      expected.push_back(leaf.probability * share * samples);
    result.without_direction += static_cast<std::uint64_t>(leaf.counts.counts().back());
    result.delta_error = std::max(result.delta_error, leaf.counts.delta_error());
  }
  result.passed_through = static_cast<std::uint64_t>(leaves.passed());
  if (leaves.passing() > 0.0 || leaves.passed() > 0.0) {
    observed.push_back(leaves.passed());
    expected.push_back(leaves.passing() * samples);
  }
  if (leaves.unforeseen() > 0.0) {
    observed.push_back(leaves.unforeseen());
    expected.push_back(0.0);
  }
  return chi_square_test(observed, expected,
                         {.min_expected = settings.min_exp_frequency,
                          .impossible_share = std::max(narrow ? kCutOff : 1e-5, kStrays / samples)});
}

/// A sample that has a direction of finite density.
struct SmoothDraw {
  BsdfDraw draw;
  std::uint32_t sample = 0;
};

/// pdf and weight of samples against pdf and eval at their directions.
void check_contract(BsdfProbe& probe, const dvec3& wo, std::uint32_t seed, std::span<const SmoothDraw> draws,
                    double rounding, BsdfChi2& result) {
  std::vector<BsdfQuery> queries;
  for (const auto& [draw, sample] : draws) queries.push_back({draw.wi, sample});
  const std::vector<BsdfValue> values = probe.evaluate(wo, seed, queries, BsdfProbe::Part::mixture);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const BsdfDraw& draw = draws[i].draw;
    const double pdf_error = std::abs(draw.pdf - values[i].pdf) / draw.pdf;
    const double weight_error = largest(draw.weight - values[i].eval / draw.pdf);
    result.pdf_error = larger(result.pdf_error, pdf_error);
    result.weight_error = larger(result.weight_error, weight_error);
  }
  if (result.pdf_error > rounding) {
    result.fault = fmt::format("the pdf of a sample differs from pdf(wo, wi) by {:.3g} of itself", result.pdf_error);
  } else if (result.weight_error > rounding) {
    result.fault = fmt::format("the weight of a sample differs from eval/pdf by {:.3g}", result.weight_error);
  }
}

/// A blend's samples come from one material or the other, and have the density of their mixture: on average over its
/// choice both are the same.
void check_mixtures(BsdfProbe& probe, const dvec3& wo, std::uint32_t seed, std::span<const SmoothDraw> draws,
                    const TestLeaves& leaves, double rounding, BsdfChi2& result) {
  std::vector<BsdfQuery> queries;
  std::vector<std::pair<std::size_t, std::size_t>> terms;  // draws, and outcomes that could have been
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const TestLeaves::Pair& pair = leaves.pairs()[leaves.pair_of(draws[i].sample)];
    if (!pair.complete) continue;
    for (const std::size_t outcome : pair.outcomes) {
      queries.push_back({draws[i].draw.wi, leaves.example(outcome)});
      terms.emplace_back(i, outcome);
    }
  }
  const std::vector<BsdfValue> mixed = probe.evaluate(wo, seed, queries, BsdfProbe::Part::mixture);
  const std::vector<BsdfValue> chosen = probe.evaluate(wo, seed, queries, BsdfProbe::Part::chosen);
  std::vector<double> density(draws.size(), 0.0), expected(draws.size(), 0.0);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    density[terms[i].first] += leaves.probability(terms[i].second) * mixed[i].pdf;
    expected[terms[i].first] += leaves.probability(terms[i].second) * chosen[i].pdf;
  }
  for (std::size_t i = 0; i < draws.size(); ++i) {
    if (density[i] != expected[i])
      result.mixture_error =
          larger(result.mixture_error, std::abs(density[i] - expected[i]) / std::max(density[i], expected[i]));
  }
  if (result.mixture_error > rounding && result.fault.empty())
    result.fault = fmt::format("the density of a mixture differs from that of what is chosen by {:.3g} of itself",
                               result.mixture_error);
}

/// The materials chosen have to be those that the scene's adapters should choose: by the density at their samples, of
/// which the median tells one material from another, whatever rounding does to narrow lobes.
void check_choices(BsdfProbe& probe, const dvec3& wo, std::uint32_t seed, std::span<const SmoothDraw> draws,
                   const TestLeaves& leaves, BsdfChi2& result) {
  constexpr double kAnother = 0.01;
  constexpr std::size_t kFew = 16;
  std::vector<BsdfQuery> queries;
  for (const auto& [draw, sample] : draws) queries.push_back({draw.wi, sample});
  const std::vector<BsdfValue> chosen = probe.evaluate(wo, seed, queries, BsdfProbe::Part::chosen);
  std::vector<std::vector<double>> differences(leaves.leaves().size());
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const std::optional<std::size_t> leaf = leaves.leaf_of(draws[i].sample);
    if (!leaf) continue;
    const TestLeaf& of = leaves.leaves()[*leaf];
    const reference::Frame& frame = of.chosen.frame;
    const double expected = reference::pdf(of.bsdf, frame.to_local(wo), frame.to_local(draws[i].draw.wi));
    differences[*leaf].push_back(std::abs(chosen[i].pdf - expected) / std::max(chosen[i].pdf, expected));
  }
  for (std::vector<double>& of_leaf : differences) {
    if (of_leaf.size() < kFew) continue;
    const auto median = of_leaf.begin() + static_cast<std::ptrdiff_t>(of_leaf.size() / 2);
    std::nth_element(of_leaf.begin(), median, of_leaf.end());
    if (!(*median <= kAnother) && result.fault.empty())
      result.fault = fmt::format(
          "the density of a material that was chosen is {:.3g} off in the median: it is another, "
          "or has another normal",
          *median);
  }
}

/// At `angle` degrees, or even over the hemisphere a material is lit from; materials with two sides are seen from both
/// in turn.
dvec3 incident_direction(const Scene& patch, std::optional<double> angle, std::uint32_t seed) {
  std::mt19937_64 engine(seed);
  const auto unit = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  const double cosine = 0.02 + 0.98 * unit(), phi = 2.0 * std::numbers::pi * unit();
  if (angle) return spherical_direction(std::cos(*angle * std::numbers::pi / 180.0), phi);
  const bool behind = has_two_sides(patch) && seed % 2 == 1;
  return spherical_direction(behind ? -cosine : cosine, phi);
}

std::string verdict_of(const BsdfChi2& t) {
  if (!t.tested)
    return fmt::format("{}: {} samples do not fill two cells", t.passed ? "not tested, allowed" : "NOT TESTED",
                       t.samples);
  return fmt::format("{}{}", t.passed ? "passed" : "FAILED", t.fault.empty() ? "" : ": " + t.fault);
}

std::string direction_text(const dvec3& d) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", d.x, d.y, d.z);
}

}  // namespace

bool Chi2Report::passed() const {
  return std::all_of(tests.begin(), tests.end(), [](const BsdfChi2& t) { return t.passed; });
}

BsdfChi2 test_bsdf(BsdfProbe& probe, const Scene& patch, const glm::dvec3& wo, const Chi2Test& settings,
                   std::uint64_t samples, std::uint32_t seed, double level) {
  const auto start = std::chrono::steady_clock::now();
  BsdfChi2 result;
  result.wo = wo;
  result.samples = samples;
  TestLeaves leaves(patch, wo, settings.resolution, seed);
  std::vector<SmoothDraw> smooth;  // of the first samples
  for (std::uint64_t done = 0; done < samples; done += kChunk) {
    const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(kChunk, samples - done));
    const std::vector<BsdfDraw> draws = probe.sample(wo, seed, static_cast<std::uint32_t>(done), count);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto sample = static_cast<std::uint32_t>(done) + i;
      leaves.add(draws[i], sample);
      const bool scattered = draws[i].pdf != 0.0 && draws[i].lobe != ProbeLobe::passed;
      result.without_light += scattered && draws[i].weight == dvec3(0.0);
      if (sample < kContractSamples && scattered && !is_delta(draws[i].lobe)) smooth.push_back({draws[i], sample});
    }
  }
  double rounding = kRounding;
  for (const TestLeaf& leaf : leaves.leaves()) rounding = std::max(rounding, rounding_of(leaf.bsdf));
  check_contract(probe, wo, seed, smooth, rounding, result);
  check_mixtures(probe, wo, seed, smooth, leaves, rounding, result);
  if (leaves.adapted()) check_choices(probe, wo, seed, smooth, leaves, result);
  result.test = test_counts(probe, wo, seed, leaves, settings, result);
  if (result.delta_error > kRounding)
    result.fault = fmt::format("a delta sample differs from its closed form by {:.3g}", result.delta_error);
  result.tested = !result.fault.empty() || result.test.p_value < level || result.test.made;
  result.passed = result.tested && result.fault.empty() && result.test.p_value >= level;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Chi2Report run_chi2(const Chi2Test& test, const std::string& file, const BsdfProbeFactory& make_probe,
                    const Chi2Options& options) {
  Chi2Report report;
  report.file = file;
  report.seed = options.seed;
  report.significance_level = options.significance_level.value_or(test.significance_level);
  const std::uint64_t directions = std::uint64_t{test.test_count} * std::max<std::size_t>(test.angles.size(), 1);
  report.test_level = sidak_level(report.significance_level, directions * test.bsdfs.size());
  const std::uint64_t cells = std::uint64_t{2} * test.resolution * test.resolution;
  const std::uint64_t samples = options.sample_count.value_or(test.sample_count > 0 ? test.sample_count : 5000 * cells);
  if (samples == 0 || samples > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorKind::usage,
                fmt::format("{}: {} samples a test is not between 1 and 2^32 − 1; set sampleCount", file, samples));
  }
  for (const TestBsdf& bsdf : test.bsdfs) {
    const std::unique_ptr<BsdfProbe> probe = make_probe(bsdf.patch);
    report.device = probe->device_name();
    report.driver = probe->driver_name();
    for (std::uint64_t i = 0; i < directions; ++i) {
      std::optional<double> angle;
      if (!test.angles.empty()) angle = test.angles[i / test.test_count];
      const std::uint32_t seed = options.seed + static_cast<std::uint32_t>(report.tests.size());
      const dvec3 wo = incident_direction(bsdf.patch, angle, seed);
      BsdfChi2 result = test_bsdf(*probe, bsdf.patch, wo, test, samples, seed, report.test_level);
      result.name = fmt::format("{}, wo {}", bsdf.name, direction_text(wo));
      result.passed = result.passed || (!result.tested && options.allow_untested);
      report.tests.push_back(std::move(result));
    }
  }
  return report;
}

std::string chi2_table(const Chi2Report& report) {
  std::string out = fmt::format("{} on {} ({}), seed {}\n", text::printable(report.file, text::kLongestLine),
                                report.device, report.driver, report.seed);
  out += fmt::format("{:<38} {:>10} {:>6} {:>6} {:>10} {:>10} {:>9}  verdict\n", "material", "samples", "cells",
                     "pooled", "chi2", "p", "pdf sum");
  std::size_t passed = 0, untested = 0;
  for (const BsdfChi2& t : report.tests) {
    passed += t.passed && t.tested;
    untested += !t.tested;
    out += fmt::format("{:<38} {:>10} {:>6} {:>6} {:>10.4g} {:>10.4g} {:>9.6g}  {}\n", t.name, t.samples, t.test.cells,
                       t.test.pooled, t.test.statistic, t.test.p_value, t.pdf_integral, verdict_of(t));
  }
  return out + fmt::format("{}: {} of {} passed{}; false-alarm rate of the file {:.4g}, of one test {:.4g} (Šidák)\n",
                           report.passed() ? "passed" : "FAILED", passed, report.tests.size(),
                           untested > 0 ? fmt::format(", {} not tested", untested) : "", report.significance_level,
                           report.test_level);
}

Json chi2_json(const Chi2Report& report) {
  Json tests = Json::array();
  for (const BsdfChi2& t : report.tests) {
    tests.push_back({{"name", t.name},
                     {"wo", {t.wo.x, t.wo.y, t.wo.z}},
                     {"samples", t.samples},
                     {"withoutDirection", t.without_direction},
                     {"withoutLight", t.without_light},
                     {"passedThrough", t.passed_through},
                     {"chi2", t.test.statistic},
                     {"cells", t.test.cells},
                     {"pooled", t.test.pooled},
                     {"degreesOfFreedom", t.test.dof},
                     {"p", t.test.p_value},
                     {"impossible", t.test.impossible},
                     {"pdfIntegral", t.pdf_integral},
                     {"pdfError", t.pdf_error},
                     {"weightError", t.weight_error},
                     {"mixtureError", t.mixture_error},
                     {"deltaError", t.delta_error},
                     {"fault", t.fault},
                     {"seconds", t.seconds},
                     {"tested", t.tested},
                     {"passed", t.passed}});
  }
  return {{"file", report.file},
          {"device", report.device},
          {"driver", report.driver},
          {"seed", report.seed},
          {"significanceLevel", report.significance_level},
          {"testLevel", report.test_level},
          {"tests", tests},
          {"passed", report.passed()}};
}

std::vector<JunitCase> chi2_junit(const Chi2Report& report) {
  std::vector<JunitCase> cases;
  for (const BsdfChi2& t : report.tests) {
    JunitCase c;
    c.name = report.file + ": " + t.name;
    c.seconds = t.seconds;
    c.failed = !t.passed;
    c.skipped = t.passed && !t.tested;
    c.message = !t.tested         ? verdict_of(t)
                : t.fault.empty() ? fmt::format("chi2 = {:.5g} with {} degrees of freedom, p = {:.3g} < {:.3g}",
                                                t.test.statistic, t.test.dof, t.test.p_value, report.test_level)
                                  : t.fault;
    c.details = fmt::format("n = {}, cells = {}, chi2 = {:.6g}, p = {:.5g}, integral of the pdf = {:.7g}", t.samples,
                            t.test.cells, t.test.statistic, t.test.p_value, t.pdf_integral);
    cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace etendue
