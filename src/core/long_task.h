#pragma once
/// How far a long computation has come, for the person who waits for it.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace etendue {

/// Says nothing for the first seconds, so that short tasks stay silent; then tells the sink of log.h up to five times a
/// second.
class LongTask {
 public:
  using Seconds = std::chrono::duration<double>;
  /// `what` is the beginning of the line: "Building the tree". Parts of it are `total`.
  LongTask(std::string what, std::uint64_t total, Seconds silent = Seconds(2.0));
  ~LongTask();
  LongTask(const LongTask&) = delete;
  LongTask& operator=(const LongTask&) = delete;
  /// `parts` more are done. From any thread.
  void advance(std::uint64_t parts);

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  std::uint64_t total_;
  std::atomic<std::uint64_t> done_{0};
  std::mutex mutex_;  // of what follows
  Clock::time_point next_;
  bool shown_ = false;
};

}  // namespace etendue
