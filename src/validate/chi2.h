#pragma once
/// `etendue chi2` and the bsdf part of `etendue ttest`: does the sampling of a material do what its density says?

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "render/bsdf_probe.h"
#include "validate/junit.h"
#include "validate/statistics.h"
#include "validate/ttest.h"

namespace etendue {

struct Chi2Options {
  std::uint32_t seed = 0;                     ///< of the first test; test i takes seed + i
  std::optional<double> significance_level;   ///< instead of the file's, in (0,1)
  std::optional<std::uint64_t> sample_count;  ///< instead of the file's
  bool allow_untested = false;                ///< a test that could not be made passes
};

/// One material at one direction of incidence.
struct BsdfChi2 {
  std::string name;  ///< "diffuse 1, wo (0.36, 0.48, 0.8)"
  glm::dvec3 wo{0.0};
  std::uint64_t samples = 0;
  std::uint64_t without_direction = 0;  ///< samples of pdf 0
  std::uint64_t without_light = 0;      ///< samples with a direction, but of weight 0
  std::uint64_t passed_through = 0;     ///< samples for which an adapter let light pass
  ChiSquareResult test;                 ///< histogram over (cos θ, φ) and the delta lobes against their probabilities
  double pdf_integral = 0;              ///< of the smooth part over the sphere
  double pdf_error = 0;                 ///< largest relative difference between the pdf of a sample and pdf(wo, wi)
  double weight_error = 0;              ///< the same of weight · pdf against eval(wo, wi)
  double mixture_error = 0;             ///< the same of a mixture's mean density against that of what is chosen
  double delta_error =
      0;              ///< largest difference of a delta sample from its closed form: direction, probability, weight
  std::string fault;  ///< a contract broken beyond rounding; such a test fails without statistics
  double seconds = 0;
  bool tested = true;   ///< false: no fault, but too few samples for a histogram of two cells
  bool passed = false;  ///< untested ones only where that is allowed
};

struct Chi2Report {
  std::string file;
  std::string device, driver;
  std::uint32_t seed = 0;
  double significance_level = 0;  ///< of the file
  double test_level = 0;          ///< of one test (Šidák)
  std::vector<BsdfChi2> tests;
  bool passed() const;
};

/// Tests every bsdf of the file at `test_count` directions. Throws whatever the probe throws.
Chi2Report run_chi2(const Chi2Test& test, const std::string& file, const BsdfProbeFactory& make_probe,
                    const Chi2Options& options = {});

/// One test of the probe of a patch. `level` is its significance.
BsdfChi2 test_bsdf(BsdfProbe& probe, const Scene& patch, const glm::dvec3& wo, const Chi2Test& settings,
                   std::uint64_t samples, std::uint32_t seed, double level);

std::string chi2_table(const Chi2Report& report);
Json chi2_json(const Chi2Report& report);
std::vector<JunitCase> chi2_junit(const Chi2Report& report);

/// A `<test type="ttest">` with bsdfs: the mean luminance of the weight of each bsdf at each angle against its
/// reference.
TTestReport run_bsdf_ttest(const TTest& test, const std::string& file, const BsdfProbeFactory& make_probe,
                           const TTestOptions& options = {});

}  // namespace etendue
