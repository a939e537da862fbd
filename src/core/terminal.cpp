#include "core/terminal.h"

#include <limits.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include <fmt/core.h>

#include "core/printable.h"

namespace etendue {
namespace {

std::atomic<bool> g_line_is_open{false};
// Whether the last wait for a reader of stderr was in vain.
std::atomic<bool> g_stalled{false};
constexpr int kPatience = 2000;  // ms

// Whether stderr accepts bytes now or within `patience` ms. An error counts as acceptance; the write that follows will
// find it.
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

}  // namespace

namespace terminal {

bool stderr_is_terminal() {
  return isatty(STDERR_FILENO) == 1;
}

bool use_color() {
  const char* no_color = std::getenv("NO_COLOR");
  return stderr_is_terminal() && (no_color == nullptr || *no_color == '\0');
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

void print(std::string_view text) noexcept {
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void put_line(std::string_view line) noexcept {
  const bool rewritten = stderr_is_terminal();
  try {
    put(fmt::format("{}{}{}", rewritten ? "\r" : "", line, rewritten ? "\x1b[K" : "\n"));
  } catch (...) {  // out of memory: the next message may succeed
    return;
  }
  g_line_is_open = rewritten;
}

void end_line() noexcept {
  if (g_line_is_open.exchange(false)) put("\n");
}

}  // namespace terminal

TerminalLog::TerminalLog() {
  log::set_sink(this);
}
TerminalLog::~TerminalLog() {
  log::set_sink(nullptr);
  terminal::end_line();
}

void TerminalLog::message(log::Level level, std::string_view sentence) noexcept {
  struct Label {
    const char *text, *color;
  };
  const Label label = level == log::Level::error     ? Label{"error: ", "\x1b[31m"}
                      : level == log::Level::warning ? Label{"warning: ", "\x1b[33m"}
                      : level == log::Level::debug   ? Label{"debug: ", "\x1b[2m"}
                                                     : Label{"note: ", "\x1b[36m"};
  terminal::end_line();
  try {
    const bool colored = terminal::use_color();
    // One call per message, so that lines of several processes do not mix.
    terminal::put(fmt::format("{}{}{}{}\n", colored ? label.color : "", label.text, colored ? "\x1b[0m" : "",
                              text::printable(sentence, text::kLongestLine)));
  } catch (...) {  // no memory for the whole line
    terminal::put(sentence);
    terminal::put("\n");
  }
}

void TerminalLog::progress(std::string_view what, double fraction) noexcept {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_line_) return;
  next_line_ = now + (terminal::stderr_is_terminal() ? std::chrono::milliseconds(0) : std::chrono::milliseconds(5000));
  try {
    terminal::put_line(fmt::format("{}: {:.0f} %", what, 100.0 * fraction));
  } catch (...) {  // out of memory: the next message may succeed
  }
}

void TerminalLog::progress_ended(std::string_view) noexcept {
  next_line_ = {};
  terminal::end_line();
}

}  // namespace etendue
