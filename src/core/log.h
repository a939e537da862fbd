#pragma once
/// Messages and progress reports for the user. All go to a sink chosen by the program; without one they are discarded.
/// Nothing here throws.

#include <string_view>

namespace etendue::log {

enum class Level { error, warning, info, debug };

/// Receives messages and progress. Its functions are called one at a time, from any thread; they must not log.
class Sink {
 public:
  virtual ~Sink() = default;
  /// One sentence.
  virtual void message(Level level, std::string_view sentence) noexcept = 0;
  /// The task `what` ("Building the tree") is done to this fraction, 0 to 1; at most five times a second.
  virtual void progress(std::string_view what, double fraction) noexcept = 0;
  /// There will be no more progress for this task.
  virtual void progress_ended(std::string_view what) noexcept = 0;
};

/// Sends everything to `sink` from now on, or nowhere if it is null, which is the default. The sink must live until
/// another one is set.
void set_sink(Sink* sink) noexcept;

/// Messages above this level are dropped (default: info), and progress counts as info.
void set_level(Level level) noexcept;
Level level() noexcept;

void error(std::string_view sentence) noexcept;
void warning(std::string_view sentence) noexcept;
void info(std::string_view sentence) noexcept;
void debug(std::string_view sentence) noexcept;
void progress(std::string_view what, double fraction) noexcept;
void progress_ended(std::string_view what) noexcept;

}  // namespace etendue::log
