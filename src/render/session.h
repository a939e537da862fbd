#pragma once
/// One run of a render job on this machine: rounds, checkpoints, budgets. The caller decides when to stop, how progress
/// is shown and where pictures go; the session knows nothing about signals or terminals.

#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "render/checkpoint.h"
#include "render/render_job.h"

namespace etendue {

struct SessionOptions {
  double checkpoint_seconds = 60.0;    ///< between two checkpoints
  std::optional<double> time_seconds;  ///< time limit, counted from `start`
  std::optional<double> max_error;     ///< stop once stopping_error is at most this
  std::uint32_t set_size = 1;          ///< paths of a film sample, see Sampler::set_size
  std::uint64_t most_samples =
      std::numeric_limits<std::uint64_t>::max();  ///< stop for now at this number of film samples
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

/// Callbacks of a running session. Any function may be empty; only one at a time is called, from any thread.
struct SessionHooks {
  std::function<bool()> stop_asked;
  std::function<bool()> picture_asked;           ///< if it returns true, the round ends and `write_picture` is called
  std::function<void()> write_picture;           ///< writes the picture so far; must clear the request
  std::function<void(std::uint64_t)> progress;   ///< paths done, of all pixels, including earlier runs
  std::function<void(const std::string&)> warn;  ///< a sentence about a checkpoint that could not be written
};

enum class SessionEnd { complete, time, error, interrupted };
const char* to_text(SessionEnd end);

class Session {
 public:
  /// All of them must outlive the session.
  Session(RenderJob& job, Checkpoint& checkpoint, const SessionOptions& options, SessionHooks hooks);

  /// Renders until the job is complete or there is a reason to stop, writing checkpoints on the way. A checkpoint that
  /// cannot be written does not end the render: the previous one is kept, and writing is tried again. If anything is
  /// thrown, what was delivered is in the job, and in the checkpoint if that can be written.
  SessionEnd run(DeviceTeam& team);

 private:
  using Clock = std::chrono::steady_clock;

  SessionEnd run_rounds(DeviceTeam& team);
  bool go_on(std::uint64_t done);
  bool stop_asked() const;
  bool picture_asked() const;
  bool good_enough() const;
  bool time_is_up() const;
  void try_checkpoint();

  RenderJob& job_;
  Checkpoint& checkpoint_;
  const SessionOptions& options_;
  SessionHooks hooks_;
  bool checkpoint_fails_ = false;
  std::uint64_t round_base_ = 0;  ///< pixel samples before the current round
  Clock::time_point last_save_ = Clock::now();
  Clock::time_point round_end_;
  Clock::time_point last_pass_;
  std::chrono::duration<double> pass_time_{0.0};
};

}  // namespace etendue
