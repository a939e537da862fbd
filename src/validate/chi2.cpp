#include "validate/chi2.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "reference/bsdf.h"
#include "reference/material_probe.h"
#include "validate/closed_form.h"
#include "validate/facet_cells.h"
#include "validate/sphere_quadrature.h"

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

/// A delta lobe as theory has it.
struct DeltaLobe {
  ProbeLobe kind;
  dvec3 wi;
  double prob;
  dvec3 weight;
};

std::vector<DeltaLobe> delta_lobes(const Bsdf& bsdf, const dvec3& wo) {
  const dvec3 mirrored(-wo.x, -wo.y, wo.z);
  if (std::holds_alternative<MirrorBsdf>(bsdf)) {
    return wo.z > 0.0 ? std::vector<DeltaLobe>{{ProbeLobe::delta_reflection, mirrored, 1.0, dvec3(1.0)}}
                      : std::vector<DeltaLobe>{};
  }
  if (std::holds_alternative<NullBsdf>(bsdf)) return {{ProbeLobe::delta_transmission, -wo, 1.0, dvec3(1.0)}};
  if (const auto* metal = std::get_if<ConductorBsdf>(&bsdf)) {
    if (wo.z <= 0.0) return {};
    dvec3 weight = metal->specular_reflectance.value;
    for (int c = 0; c < 3; ++c)
      weight[c] *= closed_form::fresnel_reflectance_of_metal(wo.z, metal->index.eta.value[c], metal->index.k.value[c]);
    return {{ProbeLobe::delta_reflection, mirrored, 1.0, weight}};
  }
  if (const auto* pane = std::get_if<ThinDielectricBsdf>(&bsdf)) {
    const double f = closed_form::fresnel_reflectance(std::abs(wo.z), pane->ext_ior, pane->int_ior);
    // F + (1 − F)² F (1 + F² + F⁴ + …): all that leaves after an odd number of reflections between the faces.
    const double reflected = f < 1.0 ? f + (1.0 - f) * (1.0 - f) * f / (1.0 - f * f) : 1.0;
    std::vector<DeltaLobe> lobes{{ProbeLobe::delta_reflection, mirrored, reflected, pane->specular_reflectance.value}};
    if (reflected < 1.0)
      lobes.push_back({ProbeLobe::delta_transmission, -wo, 1.0 - reflected, pane->specular_transmittance.value});
    return lobes;
  }
  if (const auto* plastic = std::get_if<PlasticBsdf>(&bsdf)) {
    if (wo.z <= 0.0) return {};
    const auto sum = [](const dvec3& c) { return c.x + c.y + c.z; };
    const double f = closed_form::fresnel_reflectance(wo.z, plastic->ext_ior, plastic->int_ior);
    const double coat = f * sum(plastic->specular_reflectance.value);
    const double share = coat / (coat + (1.0 - f) * sum(plastic->diffuse_reflectance.value));
    return {{ProbeLobe::delta_reflection, mirrored, share, plastic->specular_reflectance.value * (f / share)}};
  }
  const auto* glass = std::get_if<DielectricBsdf>(&bsdf);
  if (glass == nullptr || wo.z == 0.0) return {};
  const double n_o = wo.z > 0.0 ? glass->ext_ior : glass->int_ior, n_t = wo.z > 0.0 ? glass->int_ior : glass->ext_ior;
  const double f = closed_form::fresnel_reflectance(std::abs(wo.z), n_o, n_t), ratio = n_o / n_t;
  std::vector<DeltaLobe> lobes{{ProbeLobe::delta_reflection, mirrored, f, glass->specular_reflectance.value}};
  if (f < 1.0) {
    const double x = -ratio * wo.x, y = -ratio * wo.y;
    const double z = std::copysign(std::sqrt(1.0 - x * x - y * y), -wo.z);
    lobes.push_back(
        {ProbeLobe::delta_transmission, {x, y, z}, 1.0 - f, ratio * ratio * glass->specular_transmittance.value});
  }
  return lobes;
}

/// Relative index n_i/n_o of what passes the surface; 1 where nothing does.
double relative_index(const Bsdf& bsdf, const dvec3& wo) {
  double index = 1.0;
  if (const auto* glass = std::get_if<RoughDielectricBsdf>(&bsdf)) index = glass->int_ior / glass->ext_ior;
  if (const auto* principled = std::get_if<PrincipledBsdf>(&bsdf)) index = principled->eta.value;
  if (const auto* gltf = std::get_if<GltfBsdf>(&bsdf)) index = gltf->thin ? 1.0 : std::max(1.001, gltf->ior.value);
  return wo.z > 0.0 ? index : 1.0 / index;
}

bool has_two_sides(const Bsdf& bsdf) {
  const reference::BsdfTraits traits = reference::traits(bsdf);
  return !traits.one_sided;
}

/// Place of a direction in the grid of cells, even over the sphere, or over the microfacets' normals of a narrow lobe.
FacetCell cell_of(const std::optional<FacetCells>& facets, const dvec3& wi) {
  return facets ? facets->cell_of(wi) : FacetCell{wi.z, std::atan2(wi.y, wi.x)};
}

/// Counts of one test: the cells of the sphere, then one per delta lobe, then the samples without a direction.
class Histogram {
 public:
  Histogram(int rings, int sectors, std::optional<FacetCells> facets, std::vector<DeltaLobe> lobes)
      : rings_(rings),
        sectors_(sectors),
        facets_(std::move(facets)),
        lobes_(std::move(lobes)),
        counts_(static_cast<std::size_t>(rings) * sectors + lobes_.size() + 1) {}

  void add(const BsdfDraw& draw) {
    if (draw.pdf == 0.0 || draw.lobe == ProbeLobe::none) {
      ++counts_.back();
    } else if (!is_delta(draw.lobe)) {
      const FacetCell cell = cell_of(facets_, draw.wi);
      const double turn = cell.phi / (2.0 * std::numbers::pi);
      const int ring = std::clamp(static_cast<int>(0.5 * (cell.height + 1.0) * rings_), 0, rings_ - 1);
      const int sector = std::clamp(static_cast<int>((turn < 0.0 ? turn + 1.0 : turn) * sectors_), 0, sectors_ - 1);
      ++counts_[static_cast<std::size_t>(ring) * sectors_ + sector];
    } else {
      add_delta(draw);
    }
  }
  int rings() const { return rings_; }
  int sectors() const { return sectors_; }
  const std::optional<FacetCells>& facets() const { return facets_; }
  const std::vector<double>& counts() const { return counts_; }
  const std::vector<DeltaLobe>& lobes() const { return lobes_; }
  double delta_error() const { return delta_error_; }

 private:
  void add_delta(const BsdfDraw& draw) {
    const auto lobe =
        std::find_if(lobes_.begin(), lobes_.end(), [&](const DeltaLobe& l) { return l.kind == draw.lobe; });
    if (lobe == lobes_.end()) {  // a lobe the material does not have
      delta_error_ = std::numeric_limits<double>::infinity();
      return;
    }
    ++counts_[counts_.size() - 1 - lobes_.size() + static_cast<std::size_t>(lobe - lobes_.begin())];
    const double error = std::max({largest(draw.wi - lobe->wi), std::abs(draw.pdf - lobe->prob),
                                   largest(draw.weight - lobe->weight) / largest(lobe->weight)});
    delta_error_ = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(delta_error_, error);
  }

  int rings_, sectors_;
  std::optional<FacetCells> facets_;
  std::vector<DeltaLobe> lobes_;
  std::vector<double> counts_;
  double delta_error_ = 0;
};

/// Integrals over the cells of the histogram. Those of facets are quartered twice beforehand: the horizon cuts them
/// anywhere, and a corner beyond it must not be missed.
std::vector<double> integrate_histogram(const SphereDensity& density, const Histogram& histogram) {
  if (!histogram.facets()) return integrate_cells(density, histogram.rings(), histogram.sectors());
  constexpr int kParts = 4;
  const std::vector<double> parts = integrate_cells(density, kParts * histogram.rings(), kParts * histogram.sectors());
  const auto sectors = static_cast<std::size_t>(histogram.sectors());
  std::vector<double> cells(static_cast<std::size_t>(histogram.rings()) * sectors, 0.0);
  for (std::size_t i = 0; i < parts.size(); ++i)
    cells[i / (kParts * sectors) / kParts * sectors + i % (kParts * sectors) / kParts] += parts[i];
  return cells;
}

/// Expectations in the order of the histogram. Fills in the integral, and the fault when it is more than 1.
std::vector<double> expectations(BsdfProbe& probe, const dvec3& wo, const Histogram& histogram, double samples,
                                 double rounding, BsdfChi2& result) {
  const SphereDensity density = [&](std::span<const dvec3> places) {
    std::vector<FacetCells::Direction> directions;
    std::vector<dvec3> wi;
    for (const dvec3& place : places) {
      directions.push_back(histogram.facets()
                               ? histogram.facets()->direction_of({place.z, std::atan2(place.y, place.x)})
                               : FacetCells::Direction{place, 1.0});
      wi.push_back(directions.back().solid_angle > 0.0 ? directions.back().wi : dvec3(0, 0, 1));
    }
    const std::vector<BsdfValue> answers = probe.evaluate(wo, wi);
    std::vector<double> values;
    for (std::size_t i = 0; i < answers.size(); ++i)
      values.push_back(directions[i].solid_angle > 0.0 ? answers[i].pdf * directions[i].solid_angle : 0.0);
    return values;
  };
  std::vector<double> expected = integrate_histogram(density, histogram);
  for (const double share : expected) result.pdf_integral += share;
  double total = result.pdf_integral;
  for (const DeltaLobe& lobe : histogram.lobes()) {
    expected.push_back(lobe.prob);
    total += lobe.prob;
  }
  if (!(total <= 1.0 + rounding)) result.fault = fmt::format("the density integrates to {:.6g}, more than 1", total);
  // The rest up to 1 is the probability of no direction; a difference below rounding counts as 0.
  expected.push_back(total < 1.0 - rounding ? 1.0 - total : 0.0);
  for (double& share : expected) share *= samples;
  return expected;
}

/// pdf and weight of samples against pdf and eval at their directions.
void check_contract(BsdfProbe& probe, const dvec3& wo, std::span<const BsdfDraw> draws, double rounding,
                    BsdfChi2& result) {
  std::vector<dvec3> directions;
  std::vector<const BsdfDraw*> smooth;
  for (const BsdfDraw& draw : draws) {
    if (draw.pdf == 0.0 || is_delta(draw.lobe)) continue;
    directions.push_back(draw.wi);
    smooth.push_back(&draw);
  }
  const std::vector<BsdfValue> values = probe.evaluate(wo, directions);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const BsdfDraw& draw = *smooth[i];
    const double pdf_error = std::abs(draw.pdf - values[i].pdf) / draw.pdf;
    const double weight_error = largest(draw.weight - values[i].eval / draw.pdf);
    result.pdf_error =
        std::isnan(pdf_error) ? std::numeric_limits<double>::infinity() : std::max(result.pdf_error, pdf_error);
    result.weight_error = std::isnan(weight_error) ? std::numeric_limits<double>::infinity()
                                                   : std::max(result.weight_error, weight_error);
  }
  if (result.pdf_error > rounding) {
    result.fault = fmt::format("the pdf of a sample differs from pdf(wo, wi) by {:.3g} of itself", result.pdf_error);
  } else if (result.weight_error > rounding) {
    result.fault = fmt::format("the weight of a sample differs from eval/pdf by {:.3g}", result.weight_error);
  }
}

/// At `angle` degrees, or even over the hemisphere a material is lit from; materials with two sides are seen from both
/// in turn.
dvec3 incident_direction(const Bsdf& bsdf, std::optional<double> angle, std::uint32_t seed) {
  std::mt19937_64 engine(seed);
  const auto unit = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  const double cosine = 0.02 + 0.98 * unit(), phi = 2.0 * std::numbers::pi * unit();
  if (angle) return spherical_direction(std::cos(*angle * std::numbers::pi / 180.0), phi);
  const bool behind = has_two_sides(bsdf) && seed % 2 == 1;
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

/// The largest allowed deviation of a sample's density from that of its direction, which is rounded to single
/// precision.
double rounding_of(const Bsdf& bsdf, const std::optional<Roughness>& narrow) {
  double rounding = kRounding;
  if (narrow) rounding *= std::max(1.0, kSharp / std::min(narrow->alpha_u.value, narrow->alpha_v.value));
  // Near the critical angle Fresnel's factor is steep, and what is bent by little has a half vector of little length.
  return reference::traits(bsdf).transmissive ? std::max(rounding, 20.0 * kRounding) : rounding;
}

}  // namespace

bool Chi2Report::passed() const {
  return std::all_of(tests.begin(), tests.end(), [](const BsdfChi2& t) { return t.passed; });
}

BsdfChi2 test_bsdf(BsdfProbe& probe, const Bsdf& bsdf, const dvec3& wo, const Chi2Test& settings, std::uint64_t samples,
                   std::uint32_t seed, double level) {
  const auto start = std::chrono::steady_clock::now();
  BsdfChi2 result;
  result.wo = wo;
  result.samples = samples;
  const std::optional<Roughness> narrow = narrow_roughness(bsdf);
  std::optional<FacetCells> facets;
  if (narrow) facets.emplace(*narrow, wo, relative_index(bsdf, wo));
  // Half of a sphere is reflection, so that the normals of its facets need twice the rings.
  const int rings = static_cast<int>(narrow ? 2 * settings.resolution : settings.resolution);
  const double rounding = rounding_of(bsdf, narrow);
  Histogram histogram(rings, static_cast<int>(2 * settings.resolution), facets, delta_lobes(bsdf, wo));
  for (std::uint64_t done = 0; done < samples; done += kChunk) {
    const auto count = static_cast<std::uint32_t>(std::min<std::uint64_t>(kChunk, samples - done));
    const std::vector<BsdfDraw> draws = probe.sample(wo, seed, static_cast<std::uint32_t>(done), count);
    for (const BsdfDraw& draw : draws) histogram.add(draw);
    if (done == 0)
      check_contract(probe, wo, std::span(draws).first(std::min<std::size_t>(kContractSamples, count)), rounding,
                     result);
  }
  result.without_direction = static_cast<std::uint64_t>(histogram.counts().back());
  const std::vector<double> expected =
      expectations(probe, wo, histogram, static_cast<double>(samples), rounding, result);
  result.test =
      chi_square_test(histogram.counts(), expected,
                      {.min_expected = settings.min_exp_frequency,
                       .impossible_share = std::max(narrow ? kCutOff : 1e-5, kStrays / static_cast<double>(samples))});
  result.delta_error = histogram.delta_error();
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
    const std::unique_ptr<BsdfProbe> probe = make_probe(bsdf.bsdf);
    report.device = probe->device_name();
    report.driver = probe->driver_name();
    for (std::uint64_t i = 0; i < directions; ++i) {
      std::optional<double> angle;
      if (!test.angles.empty()) angle = test.angles[i / test.test_count];
      const std::uint32_t seed = options.seed + static_cast<std::uint32_t>(report.tests.size());
      const dvec3 wo = incident_direction(bsdf.bsdf, angle, seed);
      BsdfChi2 result = test_bsdf(*probe, bsdf.bsdf, wo, test, samples, seed, report.test_level);
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
                     {"chi2", t.test.statistic},
                     {"cells", t.test.cells},
                     {"pooled", t.test.pooled},
                     {"degreesOfFreedom", t.test.dof},
                     {"p", t.test.p_value},
                     {"impossible", t.test.impossible},
                     {"pdfIntegral", t.pdf_integral},
                     {"pdfError", t.pdf_error},
                     {"weightError", t.weight_error},
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
