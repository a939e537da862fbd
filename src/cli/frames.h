#pragma once
/// Sequences of pictures: --frames and --fps. docs/cameras.md, "Paths".

#include <cstdint>
#include <string>
#include <vector>

#include "core/command_line.h"
#include "image/film_file.h"
#include "render/renderer.h"

namespace etendue::cli {

struct FrameOptions {
  std::string range;  ///< "A:B"; empty: one picture
  double fps = 24.0;

  void add_to(Command& command);
  bool wanted() const { return !range.empty(); }
};

/// "frame-0007.png" for frame 7 of "frame-####.png"; longer numbers are not cut. Throws Error(usage) naming the option
/// unless there is exactly one place for a number.
std::string frame_name(const char* option, const std::string& pattern, std::uint32_t frame);

/// One of the files of a frame.
struct FrameFile {
  std::string path;
  bool film = false;      ///< holds a film
  bool denoised = false;  ///< a denoised picture
};

/// Whether all files exist, belong to the render described by `wanted`, and have all its samples and AOVs.
bool is_finished(const std::vector<FrameFile>& files, const FilmHeader& wanted);

}  // namespace etendue::cli
