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

/// What is going to be written.
struct NewPicture {
  FilmHeader header;     ///< its samples are those that are wanted in the end; none: a heat map
  bool as_film = false;  ///< where the path ends in .exr
};

/// Throws Error(usage) when both options are given; Error(file) when something stands at `path` that must not be
/// replaced: a picture that is not denoised by one that is, anything that is not a picture or film of Etendue, a
/// picture of another scene or with more samples than the new one (over all pixels), a film where no film comes, of
/// another render, or that holds samples the new one does not. Returns a sentence on what will be replaced; "" when
/// nothing stands there, or an empty file. Better called before the render than after it.
std::string check_replaceable(const std::string& path, const NewPicture& picture, const OverwriteOptions& options);

/// Where to write what was rendered in the end, which may be less than was wanted when check_replaceable allowed it,
/// and something else may have come to stand there: `path`, or where that must not be replaced a name beside it,
/// "picture.partial.exr", with a warning. Throws Error(file) where there is none left.
std::string place_of(const std::string& path, const NewPicture& picture, const OverwriteOptions& options);

/// Throws Error(file) when something stands at `path` that is neither empty nor an earlier report of this kind
/// ("--json", "--junit" or "--html"): a report can be made again, a picture or a scene named by a slip of the pen
/// cannot. Nothing for an empty path.
void check_report_replaceable(const std::string& option, const std::string& path);

}  // namespace etendue::cli
