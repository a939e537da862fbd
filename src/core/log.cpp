#include "core/log.h"

#include <limits.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>

#include <fmt/core.h>

#include "core/printable.h"

namespace etendue::log {
namespace {

std::atomic<Level> g_level{Level::info};

// The last wait for a reader of stderr was in vain.
std::atomic<bool> g_stalled{false};
constexpr int kPatience = 2000;  // ms

// Whether stderr takes bytes now, or within `patience` ms. An error counts as "takes": the write that follows finds it.
bool takes_bytes(int patience) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::milliseconds(patience);
  for (;;) {
    pollfd stream{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
    const int ready = poll(&stream, 1, patience);
    if (ready >= 0 || errno != EINTR) return ready != 0;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    patience = static_cast<int>(std::max<std::int64_t>(left, 0));
  }
}

void write(Level level, const char* label, const char* color, std::string_view sentence) noexcept {
  if (level > g_level) return;
  try {
    const bool colored = use_color();
    // One call per message, so that lines of several threads do not mix.
    put(fmt::format("{}{}{}{}\n", colored ? color : "", label, colored ? "\x1b[0m" : "",
                    text::printable(sentence, text::kLongestLine)));
  } catch (...) {  // no memory for the whole line
    put(sentence);
    put("\n");
  }
}

}  // namespace

void set_level(Level level) {
  g_level = level;
}
Level level() {
  return g_level;
}

void error(std::string_view sentence) noexcept {
  write(Level::error, "error: ", "\x1b[31m", sentence);
}
void warning(std::string_view sentence) noexcept {
  write(Level::warning, "warning: ", "\x1b[33m", sentence);
}
void info(std::string_view sentence) noexcept {
  write(Level::info, "", "", sentence);
}
void debug(std::string_view sentence) noexcept {
  write(Level::debug, "debug: ", "\x1b[2m", sentence);
}

void put(std::string_view text) noexcept {
  while (!text.empty()) {
    if (!takes_bytes(g_stalled ? 0 : kPatience)) {
      g_stalled = true;
      return;
    }
    // A pipe that is ready takes PIPE_BUF bytes without blocking.
    const ssize_t written = ::write(STDERR_FILENO, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;
    g_stalled = false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

bool stderr_is_terminal() {
  return isatty(STDERR_FILENO) == 1;
}

bool use_color() {
  const char* no_color = std::getenv("NO_COLOR");
  return stderr_is_terminal() && (no_color == nullptr || *no_color == '\0');
}

}  // namespace etendue::log
