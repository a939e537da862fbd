#pragma once
/// One run of a render job on this machine: passes, checkpoints, signals, budgets.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "cli/progress.h"
#include "cli/signals.h"
#include "render/render_job.h"

namespace etendue::cli {

struct SessionOptions {
  std::vector<std::string> outputs;  ///< .exr and .png
  bool film = false;                 ///< .exr outputs are films, which can be merged and resumed
  std::string checkpoint;            ///< empty: none
  double checkpoint_seconds = 60.0;
  std::optional<double> time_seconds;  ///< stop in time, counted from `start`
  std::optional<double> max_error;     ///< stop when relative_standard_error is at most this
  std::uint32_t set_size = 1;          ///< paths of a film sample, see Sampler::set_size
  std::chrono::steady_clock::time_point start;
  bool quiet = false;
};

enum class SessionEnd { complete, time, error, interrupted };
const char* to_text(SessionEnd end);

class Session {
 public:
  Session(RenderJob& job, const SessionOptions& options);

  /// Renders until the job is complete or there is a reason to stop; checkpoints and images asked for are written on
  /// the way. When a device fails for good, the checkpoint is written before the error is passed on.
  SessionEnd run(DeviceTeam& team);

  /// Writes the checkpoint unless the last one holds everything.
  void save_checkpoint();
  void write_outputs() const;

 private:
  using Clock = std::chrono::steady_clock;

  SessionEnd run_rounds(DeviceTeam& team);
  bool go_on(std::uint64_t done);
  bool good_enough() const;
  bool time_is_up() const;

  RenderJob& job_;
  const SessionOptions& options_;
  SignalWatch signals_;
  ProgressLine line_;
  std::uint64_t saved_ = 0;       ///< samples in the checkpoint
  std::uint64_t round_base_ = 0;  ///< pixel samples before the current round
  Clock::time_point last_save_ = Clock::now();
  Clock::time_point round_end_;
  Clock::time_point last_pass_;
  std::chrono::duration<double> pass_time_{0.0};
};

/// Throws Error(file_error) when the file could not be written now: better before the render than after it. The file is
/// not touched.
void check_writable(const std::string& path);

/// The same for a checkpoint; and Error(usage) when something stands there that is neither a film nor a picture: a slip
/// of the pen must not cost a scene.
void check_checkpoint(const std::string& path);

/// Writes a film as picture (.png), picture or film (.exr).
void write_output(const std::string& path, const FilmFile& film, bool as_film);

/// Throws Error(usage) unless the path ends in .exr or .png.
void check_output_name(const std::string& path);

}  // namespace etendue::cli
