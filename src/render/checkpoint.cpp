#include "render/checkpoint.h"

#include <filesystem>
#include <new>
#include <optional>

#include <fmt/core.h>

#include "core/errors.h"
#include "image/decode.h"
#include "image/files.h"
#include "image/merge.h"
#include "render/sample_queue.h"

namespace etendue {
namespace {

/// The header of the film at `path`; nothing if there is no file or an empty one. Throws Error(file) if it is not a
/// film of the job's render.
std::optional<FilmHeader> film_there(const std::string& path, const RenderJob& job) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (!std::filesystem::exists(status)) return {};
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(path, ignored) == 0) return {};
  FilmHeader header = read_film_header(path);
  check_same_render(job.identity(), "this render", header, path);
  return header;
}

}  // namespace

Checkpoint::Checkpoint(std::string path, const RenderJob& job) : path_(std::move(path)), job_(job) {
  if (path_.empty()) return;
  const AtomicFile probe(path_);
  std::optional<FilmHeader> there;
  const bool other_kind = [&] {
    std::error_code ignored;
    return std::filesystem::exists(path_, ignored) && !is_exr(read_file(path_, 4)) && !read_file(path_, 1).empty();
  }();
  if (other_kind) {
    throw Error(ErrorKind::usage,
                fmt::format("'--checkpoint {}' would replace a file that is not a film; give another name.", path_));
  }
  try {
    there = film_there(path_, job_);
  } catch (const Error& error) {
    throw Error(
        ErrorKind::usage,
        fmt::format(
            "'--checkpoint {}' would replace a file that is not a checkpoint of this render ({}); give another name.",
            path_, error.what()));
  }
  if (!there) return;
  if (const SampleRanges surplus = difference(there->samples, job_.wanted()); !surplus.empty()) {
    throw Error(ErrorKind::usage,
                fmt::format("'--checkpoint {}' would replace a film of this render that holds the samples {}, which "
                            "were not requested; request them as well, or give another name.",
                            path_, to_text(surplus)));
  }
}

std::string Checkpoint::samples_ahead() const {
  if (path_.empty()) return "";
  const std::optional<FilmHeader> there = film_there(path_, job_);
  return there ? to_text(difference(there->samples, job_.state().samples)) : "";
}

void Checkpoint::save() {
  if (path_.empty() || job_.done() == saved_) return;
  try {
    if (!samples_ahead().empty()) return;
    write_film(path_, job_.state());
  } catch (const std::bad_alloc&) {
    throw Error(ErrorKind::file, fmt::format("{}: this machine has too little memory to write it", path_));
  }
  saved_ = job_.done();
}

}  // namespace etendue
