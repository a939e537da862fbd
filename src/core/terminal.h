#pragma once
/// stderr as a person sees it: for programs. Libraries tell what they have to tell to log.h. Nothing here throws or
/// waits long: a terminal that went away, a full disk or a broken pipe costs the message and never the work it tells
/// about.

#include <chrono>
#include <string_view>

#include "core/log.h"

namespace etendue {

/// The sink of programs: messages and progress to stderr, while it lives. On a terminal progress is one line that is
/// rewritten, elsewhere a line every few seconds.
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
/// True when stderr is a terminal that wants colour (NO_COLOR unset).
bool use_color();

/// Writes bytes to stderr as they are. What stderr does not take is dropped; a pipe that nobody reads is waited for two
/// seconds once, and not at all until it takes something again.
void put(std::string_view text) noexcept;

/// Writes to stdout, for programs without results of their own (cli/results.h has theirs).
void print(std::string_view text) noexcept;

/// A line about progress: on a terminal it takes the place of the one before, and stays open.
void put_line(std::string_view line) noexcept;
/// Ends the open line, if there is one, so that something else can be written. Messages do so themselves.
void end_line() noexcept;

}  // namespace terminal
}  // namespace etendue
