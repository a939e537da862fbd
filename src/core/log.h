#pragma once
/// Messages to the person at the terminal. Results go to stdout and are not logged; everything here goes to stderr.

#include <string_view>

namespace etendue::log {

enum class Level { error, warning, info, debug };

/// Messages above this level are dropped (default: info).
void set_level(Level level);
Level level();

void error(std::string_view sentence);
void warning(std::string_view sentence);
void info(std::string_view sentence);
void debug(std::string_view sentence);

/// True when stderr is a terminal that wants colour (NO_COLOR unset).
bool use_color();
bool stderr_is_terminal();

}  // namespace etendue::log
