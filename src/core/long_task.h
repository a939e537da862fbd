#pragma once
/// Progress of a long computation, for the waiting user.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace etendue {

/// Stays silent for the first seconds, so that short tasks report nothing; then reports to the sink of log.h up to five
/// times per second.
class LongTask {
 public:
  using Seconds = std::chrono::duration<double>;
  /// `what` is the beginning of the line: "Building the tree". The task has `total` parts.
  LongTask(std::string what, std::uint64_t total, Seconds silent = Seconds(2.0));
  ~LongTask();
  LongTask(const LongTask&) = delete;
  LongTask& operator=(const LongTask&) = delete;
  /// Reports that `parts` more are done. May be called from any thread.
  void advance(std::uint64_t parts);

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_{0};
  std::mutex mutex_;  // guards the members below
  Clock::time_point next_;
  bool shown_ = false;
};

}  // namespace etendue
