/// `etendue-mutate`, a program that is built but not installed: it plants errors in the kernels and demands that the
/// tests notice each of them.

#include <cstdio>
#include <memory>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/program.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "core/terminal.h"
#include "mutants/mutate.h"

namespace etendue::cli {
namespace {

struct Options {
  DeviceOption device;
  MutateOptions test;
  bool markdown = false;
  ResultOptions results;
};

Ending run(const Options& options) {
  options.results.begin();
  MutateOptions test = options.test;
  test.gpu = options.device.gpu_options();
  test.progress = [](const MutantOutcome& outcome) {
    if (terminal::stderr_is_terminal())
      terminal::put_line(fmt::format("{} {}", outcome.mutant.id, outcome.mutant.name));
  };
  const MutateReport report = run_mutate(test);
  terminal::end_line();
  if (options.results.wants_text()) print_text(options.markdown ? mutate_markdown(report) : mutate_text(report));
  OutputWriter files;
  options.results.write_json(files, [&] { return mutate_json(report); });
  write_text(files, options.results.junit, [&] { return junit_xml("mutate", mutate_junit(report)); });
  files.finish();
  return report.passed() ? Ending::ok : Ending::failed;
}

void add_options(Command& command, Action& action) {
  const auto options = std::make_shared<Options>();
  options->device.add_to(command);
  command.add_option("--only", options->test.only, "numbers of the mutants to run")->delimiter(',');
  command.add_flag("--all", options->test.all_tests, "run every test on every mutant, not only until one notices");
  command.add_flag("--markdown", options->markdown, "print the table of docs/validation.md");
  options->results.add_to(command);
  options->results.add_junit(command);
  action = [options] { return run(*options); };
}

}  // namespace
}  // namespace etendue::cli

int main(int argc, char** argv) {
  return etendue::cli::run_program("plants errors in the kernels and demands that the tests notice each of them",
                                   "etendue-mutate", etendue::cli::add_options, argc, argv);
}
