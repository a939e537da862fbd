#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <system_error>

#include <fmt/core.h>
#include "cli/command.h"
#include "core/command_line.h"
#include "core/errors.h"
#include "core/log.h"
#include "core/version.h"
#include "vulkan/context.h"

namespace {

using etendue::ExitCode;

ExitCode run(int argc, char** argv) {
  etendue::Command app("Etendue: a Vulkan path tracer that gives the same light on every device, and proves it.",
                       "etendue");
  app.set_version_flag(std::string("etendue ") + etendue::version());
  app.require_subcommand();
  app.footer(
      "Exit codes: 0 ok, 1 comparison or test failed, 2 usage, 3 scene error, 4 no suitable device, 5 device lost or "
      "out of memory, "
      "6 file error, 70 a bug, 77 skipped, 130 interrupted.");
  etendue::cli::Action action;
  etendue::cli::add_render_command(app, action);
  etendue::cli::add_devices_command(app, action);
  etendue::cli::add_check_command(app, action);
  etendue::cli::add_ttest_command(app, action);
  etendue::cli::add_merge_command(app, action);
  etendue::cli::add_compare_command(app, action);
  etendue::cli::add_validate_command(app, action);
  etendue::cli::add_chi2_command(app, action);
  etendue::cli::add_selftest_command(app, action);
  etendue::cli::add_mutate_command(app, action);
  etendue::cli::add_bench_command(app, action);
  etendue::cli::add_explain_command(app, action);
  if (const std::optional<bool> end = app.parse(argc, argv)) return *end ? ExitCode::ok : ExitCode::usage;
  const ExitCode code = action();
  // A run under the validation layer is only good when the layer had nothing to say.
  if (code == ExitCode::ok && etendue::vulkan::validation_message_count() > 0) {
    etendue::log::error(
        fmt::format("The validation layer sent {} messages.", etendue::vulkan::validation_message_count()));
    return ExitCode::test_failed;
  }
  return code;
}

// Results that did not arrive are no results: a full disk under a redirected stdout must not look like success.
void flush_results() {
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout) return;
  throw etendue::Error(ExitCode::file_error,
                       fmt::format("The results cannot be written to stdout: {}.", std::strerror(errno)));
}

// Runs the command; an error becomes a sentence on stderr and an exit code.
ExitCode guarded_run(int argc, char** argv) {
  try {
    const ExitCode code = run(argc, argv);
    flush_results();
    return code;
  } catch (const etendue::Error& error) {
    etendue::log::error(error.what());
    return error.code();
  } catch (const std::bad_alloc&) {
    etendue::log::error("The host ran out of memory; use a smaller image or mesh.");
    return ExitCode::device_lost;
  } catch (const std::system_error& error) {  // what fmt::print throws, above all
    etendue::log::error(fmt::format("The system refused: {}.", error.what()));
    return ExitCode::file_error;
  } catch (const std::exception& error) {
    etendue::log::error(fmt::format("This is a bug in etendue, please report it: {}.", error.what()));
    return ExitCode::bug;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int code = static_cast<int>(guarded_run(argc, argv));
  if (etendue::vulkan::any_abandoned()) {
    // The driver's threads may never end, and its exit handlers wait for them.
    std::fflush(nullptr);
    std::_Exit(code);
  }
  return code;
}
