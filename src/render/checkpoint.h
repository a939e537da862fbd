#pragma once
/// The file that stores the progress of a render.

#include <string>

#include "render/render_job.h"

namespace etendue {

/// A film file that is replaced again and again while a job runs. It never replaces anything but an older film of the
/// same render, all of whose samples the new one holds: finished samples are never lost by a wrong name or a forgotten
/// --resume.
class Checkpoint {
 public:
  /// If `path` is empty, nothing is ever written. Throws Error(usage) if the file at `path` is neither empty nor a film
  /// of this render, or holds samples that are not part of `job`; Error(file) if it cannot be read or written. Changes
  /// no file.
  Checkpoint(std::string path, const RenderJob& job);

  bool is_wanted() const { return !path_.empty(); }
  const std::string& path() const { return path_; }
  /// The samples in the file that the job lacks, as text; empty if there are none. Until the job has them as well,
  /// save() leaves the file as it is.
  std::string samples_ahead() const;

  /// Writes the samples so far, unless the last save did. Throws Error(file), also if another file has appeared at the
  /// path.
  void save();

 private:
  std::string path_;
  const RenderJob& job_;
  std::uint64_t saved_ = 0;  ///< number of sample indices in the file, from this run
};

}  // namespace etendue
