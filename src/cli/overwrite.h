#pragma once
/// Which existing files a command may replace; argued in docs/image_files.md, "Files that exist".

#include <cstdint>
#include <string>

#include "core/command_line.h"
#include "image/film_file.h"

namespace etendue::cli {

struct OverwriteOptions {
  bool force = false;       ///< replace anything
  bool no_clobber = false;  ///< replace nothing

  /// Adds --force and --no-clobber.
  void add_to(Command& command);
};

/// The file that will be written.
struct NewPicture {
  FilmHeader header;     ///< with the samples that it will finally have; none for a heat map
  bool as_film = false;  ///< if the path ends in .exr
};

/// Throws Error(usage) if both options are given. Throws Error(file) if the file at `path` must not be replaced: a
/// picture that is not denoised by one that is; anything that is not a picture or film of Etendue; a picture of another
/// scene or with more samples than the new one (over all pixels); a film by something that is not a film, or by a film
/// of another render or without all its samples. Returns a sentence about what will be replaced; "" if there is no
/// file, or an empty one. To be called before the render rather than after it.
std::string check_replaceable(const std::string& path, const NewPicture& picture, const OverwriteOptions& options);

/// The path for the final result. It may have fewer samples than when check_replaceable allowed it, or another file may
/// have appeared there meanwhile. Returns `path`, or, if that must not be replaced, a name next to it,
/// "picture.partial.exr", with a warning. Throws Error(file) if no such name is free.
std::string place_of(const std::string& path, const NewPicture& picture, const OverwriteOptions& options);

/// Throws Error(file) if the file at `path` is neither empty nor an earlier report of this kind ("--json", "--junit" or
/// "--html"): a report can be made again, but not a picture or a scene named by mistake. Does nothing for an empty
/// path.
void check_report_replaceable(const std::string& option, const std::string& path);

}  // namespace etendue::cli
