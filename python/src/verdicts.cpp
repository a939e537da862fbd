#include "module.h"

namespace etendue::python {
namespace {

/// A verdict as Python takes it: JSON, the text of the command line, and whether all is well.
using Told = std::tuple<std::string, std::string, bool>;

Told compare(const Picture& test, const std::string& test_name, const Picture& reference,
             const std::string& reference_name, double significance, const std::vector<std::string>& at_most,
             const std::vector<std::string>& at_least, bool allow_untested) {
  CompareOptions options;
  options.significance = significance;
  options.allow_untested = allow_untested;
  for (const std::string& limit : at_most) options.limits.push_back(parse_limit(limit, true));
  for (const std::string& limit : at_least) options.limits.push_back(parse_limit(limit, false));
  Comparison comparison;
  run_waiting([&] { comparison = compare_images(*test.image, test_name, *reference.image, reference_name, options); });
  return {json_text(comparison_json(comparison)), comparison_text(comparison), comparison.passed()};
}

Told ttest(const std::string& path, const std::vector<std::pair<std::string, std::string>>& parameters,
           const std::string& device, std::uint32_t seed, std::optional<std::uint64_t> samples,
           std::optional<std::uint32_t> spp, std::optional<double> significance, bool allow_untested) {
  Diagnostics diagnostics;
  std::optional<SceneFile> file;
  run_waiting([&] { file = read_scene_file(path, {.overrides = parameters}, diagnostics); });
  if (!file || diagnostics.has_errors()) throw ReadFailure(diagnostics.list());
  const auto* test = std::get_if<TTest>(&*file);
  if (test == nullptr)
    throw Error(ErrorKind::scene, path + ": holds no <test type=\"ttest\">; use render() for scenes.");
  if (spp && !test->bsdfs.empty())
    throw Error(ErrorKind::usage, path +
                                      ": tests bsdfs, which have no pixels for spp; samples says how many samples "
                                      "each test takes.");
  const TTestOptions options{.seed = seed,
                             .significance_level = significance,
                             .sample_count = samples,
                             .samples_per_pixel = spp,
                             .allow_untested = allow_untested};
  TTestReport report;
  run_waiting([&] { report = run_ttest(*test, path, {.selector = device}, options); });
  return {json_text(ttest_json(report)), ttest_table(report), report.passed()};
}

}  // namespace

void bind_verdicts(nb::module_& m) {
  m.def("compare", &compare, nb::arg("test"), nb::arg("test_name"), nb::arg("reference"), nb::arg("reference_name"),
        nb::arg("significance"), nb::arg("at_most"), nb::arg("at_least"), nb::arg("allow_untested"));
  m.def("ttest", &ttest, nb::arg("path"), nb::arg("parameters"), nb::arg("device"), nb::arg("seed"),
        nb::arg("samples").none(), nb::arg("spp").none(), nb::arg("significance").none(), nb::arg("allow_untested"));
}

}  // namespace etendue::python
