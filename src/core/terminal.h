#pragma once
/// Output to stderr, for programs; libraries report through log.h. Nothing here throws or waits long: a closed
/// terminal, a full disk or a broken pipe costs the message, never the work.

#include <chrono>
#include <string_view>

#include "core/log.h"

namespace etendue {

/// The sink for programs: during its lifetime, messages and progress go to stderr. On a terminal, progress is one line
/// that is rewritten; elsewhere, a line every few seconds.
class TerminalLog : public log::Sink {
 public:
  TerminalLog();
  ~TerminalLog() override;
  TerminalLog(const TerminalLog&) = delete;
  TerminalLog& operator=(const TerminalLog&) = delete;

  void message(log::Level level, std::string_view sentence) noexcept override;
  void progress(std::string_view what, double fraction) noexcept override;
  void progress_ended(std::string_view what) noexcept override;

 private:
  std::chrono::steady_clock::time_point next_line_{};
};

namespace terminal {

bool stderr_is_terminal();
/// True if stderr is a terminal and NO_COLOR is unset.
bool use_color();

/// Writes bytes to stderr unchanged and drops what stderr does not accept. A pipe that nobody reads is waited for once,
/// for two seconds, and then not again until it accepts something.
void put(std::string_view text) noexcept;

/// Writes to stdout, for programs without results of their own (cli/results.h has theirs).
void print(std::string_view text) noexcept;

/// Writes a line of progress: on a terminal it replaces the previous one and stays open.
void put_line(std::string_view line) noexcept;
/// Ends the open line, if any, so that something else can be written. Messages do so themselves.
void end_line() noexcept;

}  // namespace terminal
}  // namespace etendue
