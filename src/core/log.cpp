#include "core/log.h"

#include <unistd.h>

#include <atomic>
#include <cstdlib>

#include <fmt/core.h>

namespace etendue::log {
namespace {

std::atomic<Level> g_level{Level::info};

void write(Level level, const char* label, const char* color, std::string_view sentence) {
  if (level > g_level) return;
  const bool colored = use_color();
  // One call per message, so that lines of several threads do not mix.
  fmt::print(stderr, "{}{}{}{}\n", colored ? color : "", label, colored ? "\x1b[0m" : "", sentence);
}

}  // namespace

void set_level(Level level) {
  g_level = level;
}
Level level() {
  return g_level;
}

void error(std::string_view sentence) {
  write(Level::error, "error: ", "\x1b[31m", sentence);
}
void warning(std::string_view sentence) {
  write(Level::warning, "warning: ", "\x1b[33m", sentence);
}
void info(std::string_view sentence) {
  write(Level::info, "", "", sentence);
}
void debug(std::string_view sentence) {
  write(Level::debug, "debug: ", "\x1b[2m", sentence);
}

bool stderr_is_terminal() {
  return isatty(STDERR_FILENO) == 1;
}

bool use_color() {
  const char* no_color = std::getenv("NO_COLOR");
  return stderr_is_terminal() && (no_color == nullptr || *no_color == '\0');
}

}  // namespace etendue::log
