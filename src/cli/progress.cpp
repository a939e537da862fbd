#include "cli/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/core.h>

#include "core/terminal.h"

namespace etendue::cli {

std::string duration_text(double seconds) {
  const auto s = std::llround(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

ProgressLine::ProgressLine(bool quiet, std::uint64_t before, std::uint64_t total)
    : quiet_(quiet), terminal_(terminal::stderr_is_terminal()), before_(before), total_(total) {}

ProgressLine::~ProgressLine() {
  finish();
}

void ProgressLine::finish() {
  if (shown_) terminal::end_line();
  shown_ = false;
}

void ProgressLine::update(std::uint64_t done) {
  const Clock::time_point now = Clock::now();
  const auto interval = terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000);
  if (quiet_ || (now - last_ < interval && done < total_) || (!terminal_ && !shown_ && done >= total_)) return;
  last_ = now;
  shown_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const double rate = seconds > 0.0 ? static_cast<double>(done - std::min(before_, done)) / seconds : 0.0;
  const double left = rate > 0.0 ? static_cast<double>(total_ - done) / rate : 0.0;
  terminal::put_line(fmt::format("{:3.0f} %  {}/{} samples  {:.2f} Msamples/s  {} left",
                                 100.0 * static_cast<double>(done) / static_cast<double>(total_), done, total_,
                                 rate * 1e-6, duration_text(left)));
}

}  // namespace etendue::cli
