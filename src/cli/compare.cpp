#include "validate/compare.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "core/errors.h"
#include "core/log.h"
#include "core/memory.h"
#include "image/picture_header.h"
#include "validate/html_report.h"

namespace etendue::cli {
namespace {

struct CompareArguments {
  std::string test, reference;
  std::vector<std::string> above, below;
  double significance = 0.01;
  bool no_flip = false;
  bool allow_untested = false;
  ResultOptions results;
};

/// Both pictures are kept in memory, plus one file while it is unpacked. If that is too much, an error is better than
/// letting the system kill this program or another one.
void check_memory(const CompareArguments& options, const PictureHeader& header) {
  constexpr std::uint64_t kPixelBytes = 28;  // color, standard error, sample count
  std::error_code error;
  const auto size = [&](const std::string& path) { return std::uint64_t{std::filesystem::file_size(path, error)}; };
  const std::uint64_t files = std::max(size(options.test), size(options.reference));
  const std::uint64_t pixels = std::uint64_t{header.width} * header.height;
  const std::uint64_t needed = 2 * kPixelBytes * pixels + (error ? 0 : files), available = available_memory();
  if (needed <= available) return;
  throw Error(
      ErrorKind::lost,
      fmt::format("Comparing two pictures of {}x{} pixels takes {:.1f} GB of memory, and {:.1f} GB are available; "
                  "compare smaller pictures, or on another machine.",
                  header.width, header.height, 1e-9 * static_cast<double>(needed),
                  1e-9 * static_cast<double>(available)));
}

Ending run_compare(const CompareArguments& options) {
  options.results.begin();
  CompareOptions compare;
  compare.significance = options.significance;
  compare.metrics.flip = !options.no_flip;
  compare.allow_untested = options.allow_untested;
  for (const std::string& text : options.above) compare.limits.push_back(parse_limit(text, true));
  for (const std::string& text : options.below) compare.limits.push_back(parse_limit(text, false));
  // Checked before gigabytes are unpacked from a small file: pictures of different sizes cannot be compared.
  const PictureHeader a = read_picture_header(options.test), b = read_picture_header(options.reference);
  require_same_size(a.width, a.height, b.width, b.height);
  check_memory(options, a);
  const Image test = read_image(options.test), reference = read_image(options.reference);
  for (const auto& [path, image] : {std::pair(&options.test, &test), {&options.reference, &reference}}) {
    if (image->metadata.contains("toneMapping") || image->metadata.contains("exposure"))
      log::warning(
          fmt::format("{}: was written with --tonemap or --exposure and does not show radiance; compare the EXR "
                      "files.",
                      *path));
  }
  const Comparison comparison = compare_images(test, options.test, reference, options.reference, compare);
  if (options.results.wants_text()) print_text(comparison_text(comparison));
  OutputWriter files;
  options.results.write_json(files, [&] { return comparison_json(comparison); });
  write_text(files, options.results.junit, [&] { return junit_xml("compare", {comparison_junit(comparison)}); });
  write_text(files, options.results.html, [&] { return comparison_html(comparison, test, reference); });
  files.finish();
  return comparison.passed() ? Ending::ok : Ending::failed;
}

}  // namespace

void add_compare_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("compare", "report how far apart two pictures are and whether chance explains it");
  const auto options = std::make_shared<CompareArguments>();
  command->add_option("A", options->test, "the picture to test (EXR or PNG)")->required()->file({".exr", ".png"});
  command->add_option("B", options->reference, "the reference picture")->required()->file({".exr", ".png"});
  command
      ->add_option("--fail-above", options->above,
                   "exit with 1 above this value of mse, rmse, relmse, mae, flip, hdrflip, bias, relbias or nonfinite")
      ->type_name("METRIC=VALUE");
  command->add_option("--fail-below", options->below, "exit with 1 below this value of psnr or ssim")
      ->type_name("METRIC=VALUE");
  command->add_option("--significance", options->significance, "false-alarm rate of the statistical tests")
      ->check(in_range(1e-12, 0.5))
      ->capture_default_str();
  command->add_flag("--no-flip", options->no_flip, "leave out FLIP and HDR-FLIP, which take most of the time");
  command->add_flag("--allow-untested", options->allow_untested,
                    "exit with 0 even if the pictures differ where the difference could not be tested");
  options->results.add_to(*command);
  options->results.add_junit(*command);
  options->results.add_html(*command);
  command->callback([&action, options] { action = [options] { return run_compare(*options); }; });
}

}  // namespace etendue::cli
