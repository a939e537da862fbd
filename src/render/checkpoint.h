#pragma once
/// The file that keeps what a render has done.

#include <string>

#include "render/render_job.h"

namespace etendue {

/// A film file that is replaced again and again while a job runs. It never replaces anything but an older film of the
/// same render, all of whose samples the new one holds: what was rendered once is not lost by a wrong name or a
/// forgotten --resume.
class Checkpoint {
 public:
  /// `path` may be empty: then nothing is ever written. Throws Error(usage) when the file at `path` is neither empty
  /// nor a film of this render, or holds samples that `job` does not want; Error(file) when it cannot be read or
  /// the place cannot be written. Touches nothing.
  Checkpoint(std::string path, const RenderJob& job);

  bool is_wanted() const { return !path_.empty(); }
  const std::string& path() const { return path_; }
  /// What the file holds and the job has not done, as text; empty when there is nothing: until the job has them, too,
  /// save() leaves the file as it is.
  std::string samples_ahead() const;

  /// Writes what is done, unless the last save did. Throws Error(file), also when something else has come to
  /// stand at the path.
  void save();

 private:
  std::string path_;
  const RenderJob& job_;
  std::uint64_t saved_ = 0;  ///< sample indices in the file, of this run
};

}  // namespace etendue
