#include "validate/selftest.h"

#include <memory>
#include <random>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "core/terminal.h"

namespace etendue::cli {
namespace {

struct SelftestArguments {
  DeviceOption device;
  SelftestOptions test;
  std::optional<std::uint64_t> seed;
  ResultOptions results;
};

Ending run(const SelftestArguments& options) {
  options.results.begin();
  SelftestOptions test = options.test;
  test.seed = options.seed ? *options.seed
                           : std::random_device()() & 0x7fffffffu;  // printed, so that a failure can be repeated
  if (test.seeds > 1 && !options.results.quiet && terminal::stderr_is_terminal()) {
    test.progress = [&](std::uint32_t done) {
      terminal::put_line(fmt::format("{} of {} suites", done, test.seeds));
      if (done == test.seeds) terminal::end_line();
    };
  }
  const SelftestReport report = run_selftest(options.device.factory(), options.device.probe_factory(), test);
  if (options.results.wants_text()) print_text(selftest_text(report));
  OutputWriter files;
  options.results.write_json(files, [&] { return selftest_json(report); });
  write_text(files, options.results.junit, [&] { return junit_xml("selftest", selftest_junit(report)); });
  files.finish();
  return report.passed() ? Ending::ok : Ending::failed;
}

}  // namespace

void add_selftest_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("selftest", "test new random scenes and materials with known closed-form answers");
  const auto options = std::make_shared<SelftestArguments>();
  options->device.add_to(*command);
  command->add_option("--seed", options->seed, "seed of the first suite (default: a new one, which is printed)");
  command->add_option("--seeds", options->test.seeds, "number of suites")
      ->check(in_range(1, 1000000))
      ->capture_default_str();
  command->add_option("--samples", options->test.samples, "samples of each test")
      ->check(in_range(100, 1 << 30))
      ->capture_default_str();
  command->add_option("--significance", options->test.significance, "probability that a suite fails without an error")
      ->check(in_range(1e-12, 0.5))
      ->capture_default_str();
  command->add_flag("--allow-untested", options->test.allow_untested,
                    "exit with 0 even if there were too few samples for a test");
  options->results.add_to(*command);
  options->results.add_junit(*command);
  command->callback([&action, options] { action = [options] { return run(*options); }; });
}

}  // namespace etendue::cli
