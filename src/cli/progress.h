#pragma once
/// The progress line on stderr.

#include <chrono>
#include <cstdint>
#include <string>

namespace etendue::cli {

/// One line that is rewritten if stderr is a terminal, otherwise a line every few seconds; nothing if quiet.
class ProgressLine {
 public:
  /// The job has `total` pixel samples; `before` of them were done by earlier runs and do not count for the speed.
  ProgressLine(bool quiet, std::uint64_t before, std::uint64_t total);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  /// `done` pixel samples of the job are done, including those of earlier runs.
  void update(std::uint64_t done);
  /// Ends the line, so that something else can be written.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  bool quiet_, terminal_, shown_ = false;
  std::uint64_t before_, total_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = Clock::now();
};

/// "12 s", "3 min 05 s", "2 h 07 min".
std::string duration_text(double seconds);

}  // namespace etendue::cli
