#include "validate/compare.h"

#include <cstdio>
#include <memory>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "validate/html_report.h"

namespace etendue::cli {
namespace {

struct Options {
  std::string test, reference;
  std::vector<std::string> above, below;
  double significance = 0.01;
  bool no_flip = false;
  ResultFiles files;
};

ExitCode run_compare(const Options& options) {
  options.files.check();
  CompareOptions compare;
  compare.significance = options.significance;
  compare.metrics.flip = !options.no_flip;
  for (const std::string& text : options.above) compare.limits.push_back(parse_limit(text, true));
  for (const std::string& text : options.below) compare.limits.push_back(parse_limit(text, false));
  const Image test = read_image(options.test), reference = read_image(options.reference);
  const Comparison comparison = compare_images(test, options.test, reference, options.reference, compare);
  print_result("{}", comparison_text(comparison));
  OutputWriter files;
  write_text(files, options.files.json, [&] { return json_text(comparison_json(comparison)); });
  write_text(files, options.files.junit, [&] { return junit_xml("compare", {comparison_junit(comparison)}); });
  write_text(files, options.files.html, [&] { return comparison_html(comparison, test, reference); });
  files.finish();
  return comparison.passed() ? ExitCode::ok : ExitCode::test_failed;
}

}  // namespace

void add_compare_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("compare", "say how far apart two pictures are and whether chance explains it");
  const auto options = std::make_shared<Options>();
  command->add_option("A", options->test, "the picture in question (EXR or PNG)")->required();
  command->add_option("B", options->reference, "the picture it is held against")->required();
  command->add_option("--fail-above", options->above,
                      "METRIC=VALUE, exit 1 beyond: mse rmse relmse mae flip hdrflip bias relbias nonfinite");
  command->add_option("--fail-below", options->below, "METRIC=VALUE, exit 1 below: psnr ssim");
  command->add_option("--significance", options->significance, "false-alarm rate of the statistical tests")
      ->check(in_range(1e-12, 0.5))
      ->capture_default_str();
  command->add_flag("--no-flip", options->no_flip, "leave out FLIP and HDR-FLIP, which take most of the time");
  options->files.add_to(*command, true);
  command->callback([&action, options] { action = [options] { return run_compare(*options); }; });
}

}  // namespace etendue::cli
