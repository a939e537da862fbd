#pragma once
/// Messages to the person at the terminal. Results go to stdout and are not logged; everything here goes to stderr.
/// Nothing here throws or waits long: a terminal that went away, a full disk or a broken pipe costs the message and
/// never the work it tells about.

#include <string_view>

namespace etendue::log {

enum class Level { error, warning, info, debug };

/// Messages above this level are dropped (default: info).
void set_level(Level level);
Level level();

void error(std::string_view sentence) noexcept;
void warning(std::string_view sentence) noexcept;
void info(std::string_view sentence) noexcept;
void debug(std::string_view sentence) noexcept;

/// Writes bytes to stderr as they are: progress lines. What stderr does not take is dropped; a pipe that nobody reads
/// is waited for two seconds once, and not at all until it takes something again.
void put(std::string_view text) noexcept;

/// True when stderr is a terminal that wants colour (NO_COLOR unset).
bool use_color();
bool stderr_is_terminal();

}  // namespace etendue::log
