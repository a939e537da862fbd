#include "core/long_task.h"

#include <algorithm>

#include <fmt/core.h>

#include "core/log.h"

namespace etendue {

LongTask::LongTask(std::string what, std::uint64_t total, Seconds silent)
    : what_(std::move(what)),
      total_(std::max<std::uint64_t>(total, 1)),
      terminal_(log::stderr_is_terminal()),
      next_(Clock::now() + std::chrono::duration_cast<Clock::duration>(silent)) {}

LongTask::~LongTask() {
  if (shown_ && terminal_) log::put("\n");
}

void LongTask::advance(std::uint64_t parts) {
  const std::uint64_t done = done_ += parts;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  const Clock::time_point now = Clock::now();
  if (!lock || now < next_ || log::level() < log::Level::info) return;
  next_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000));
  shown_ = true;
  const double percent = 100.0 * static_cast<double>(std::min(done, total_)) / static_cast<double>(total_);
  log::put(fmt::format("{}{}: {:.0f} %{}", terminal_ ? "\r" : "", what_, percent, terminal_ ? "   " : "\n"));
}

}  // namespace etendue
