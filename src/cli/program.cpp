#include "cli/program.h"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <system_error>

#include <fmt/core.h>
#include "cli/results.h"
#include "core/command_line.h"
#include "core/errors.h"
#include "core/log.h"
#include "core/terminal.h"
#include "core/version.h"
#include "vulkan/context.h"

namespace {

using etendue::ErrorKind;
using etendue::cli::CommandSetup;
using etendue::cli::Ending;
using etendue::cli::exit_code;

int run(const std::string& description, const std::string& name, const CommandSetup& set_up, int argc, char** argv) {
  etendue::Command app(description, name);
  app.set_version_flag(name + " " + etendue::version());
  app.footer(
      "Exit codes: 0 success, 1 a comparison or a test failed, 2 the command line is wrong, 3 the scene or a mesh is "
      "wrong, 4 no suitable device, 5 device lost or out of memory, 6 a file cannot be read or written, 70 a bug in "
      "the program, 77 skipped, 130 interrupted after saving what was done.");
  etendue::cli::Action action;
  set_up(app, action);
  if (const std::optional<bool> end = app.parse(argc, argv, etendue::cli::print_text))
    return *end ? exit_code(Ending::ok) : exit_code(ErrorKind::usage);
  const etendue::cli::Result result = action();
  // A run under the validation layer succeeds only if the layer reported nothing.
  if (result == etendue::cli::Result(Ending::ok) && etendue::vulkan::validation_message_count() > 0) {
    etendue::log::error(
        fmt::format("The validation layer sent {} messages.", etendue::vulkan::validation_message_count()));
    return exit_code(Ending::failed);
  }
  return std::visit([](auto end) { return exit_code(end); }, result);
}

// If a stream is closed, full, or a pipe without a reader, only the text written to it may be lost. Closed streams are
// replaced by a file that refuses writes; otherwise the next file opened would get their number and receive their text.
void guard_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) >= 0) continue;
    // This takes the lowest free number, which is `stream`. Without /dev/null nothing can be done.
    [[maybe_unused]] const int opened = open("/dev/null", O_RDONLY);
  }
}

// Runs the command; an error becomes a sentence on stderr and an exit code.
int guarded_run(const std::string& description, const std::string& name, const CommandSetup& set_up, int argc,
                char** argv) {
  try {
    const int code = run(description, name, set_up, argc, argv);
    // Results must have arrived: a full disk under a redirected stdout must not look like success.
    etendue::cli::finish_results();
    return code;
  } catch (const etendue::Error& error) {
    etendue::log::error(error.what());
    return exit_code(error.kind());
  } catch (const std::bad_alloc&) {
    etendue::log::error("The host ran out of memory; use a smaller image or mesh.");
    return exit_code(ErrorKind::lost);
  } catch (const std::system_error& error) {
    etendue::log::error(fmt::format("The system refused: {}.", error.what()));
    return exit_code(ErrorKind::file);
  } catch (const std::exception& error) {
    etendue::log::error(fmt::format("This is a bug in etendue, please report it: {}.", error.what()));
    return exit_code(ErrorKind::bug);
  }
}

}  // namespace

// README.md lists these numbers; 77, "skipped", is only for tests.
int etendue::cli::exit_code(Ending ending) {
  switch (ending) {
    case Ending::ok:
      return 0;
    case Ending::failed:
      return 1;
    case Ending::interrupted:
      return 130;
  }
  return 70;
}

int etendue::cli::exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::comparison:
      return 1;
    case ErrorKind::usage:
      return 2;
    case ErrorKind::scene:
      return 3;
    case ErrorKind::device:
      return 4;
    case ErrorKind::lost:
      return 5;
    case ErrorKind::file:
      return 6;
    case ErrorKind::bug:
      return 70;
    case ErrorKind::interrupted:
      return 130;
  }
  return 70;
}

int etendue::cli::run_program(const std::string& description, const std::string& name, const CommandSetup& set_up,
                              int argc, char** argv) {
  guard_streams();
  const etendue::TerminalLog messages;
  const int code = guarded_run(description, name, set_up, argc, argv);
  if (etendue::vulkan::any_abandoned()) {
    // The driver's threads may never end, and its exit handlers wait for them.
    std::fflush(nullptr);
    std::_Exit(code);
  }
  return code;
}
