#include "core/long_task.h"

#include <algorithm>

#include "core/log.h"

namespace etendue {

LongTask::LongTask(std::string what, std::uint64_t total, Seconds silent)
    : what_(std::move(what)),
      total_(std::max<std::uint64_t>(total, 1)),
      next_(Clock::now() + std::chrono::duration_cast<Clock::duration>(silent)) {}

LongTask::~LongTask() {
  if (shown_) log::progress_ended(what_);
}

void LongTask::advance(std::uint64_t parts) {
  const std::uint64_t done = done_ += parts;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  const Clock::time_point now = Clock::now();
  if (!lock || now < next_) return;
  next_ = now + std::chrono::milliseconds(200);
  shown_ = true;
  log::progress(what_, static_cast<double>(std::min(done, total_)) / static_cast<double>(total_));
}

}  // namespace etendue
