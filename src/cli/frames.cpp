#include "cli/frames.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "image/merge.h"
#include "image/picture_header.h"
#include "render/sample_queue.h"

namespace etendue::cli {
namespace {

constexpr char kPlace = '#';

bool has_aovs(const PictureHeader& header, const FilmHeader& wanted) {
  for (const AovHeader& aov : wanted.aovs) {
    for (const std::string& name : channel_names(aov.aov)) {
      if (std::ranges::find(header.channels, name) == header.channels.end()) return false;
    }
  }
  return true;
}

bool is_finished_file(const FrameFile& file, const FilmHeader& wanted) {
  try {
    const PictureHeader header = read_picture_header(file.path);
    return header.film == file.film && header.metadata.contains(kDenoisedKey) == file.denoised &&
           header.width == wanted.width && header.height == wanted.height &&
           same_samples(header.metadata, wanted.metadata) && difference(wanted.samples, header.samples).empty() &&
           (file.denoised || !file.path.ends_with(".exr") || has_aovs(header, wanted));
  } catch (const Error&) {
    return false;  // existing files are checked before they are replaced
  }
}

}  // namespace

void FrameOptions::add_to(Command& command) {
  constexpr const char* kSection = "Frames";
  command
      .add_option("--frames", range,
                  "render the frames A to B - 1 of a camera with keyframes or an animated glTF asset; #### in output "
                  "names stands for the frame number. Finished frames are kept, an interrupted one continues")
      ->type_name("A:B")
      ->group(kSection);
  command.add_option("--fps", fps, "frames per second: frame N shows the time N / FPS")
      ->check(positive())
      ->capture_default_str()
      ->group(kSection);
}

std::string frame_name(const char* option, const std::string& pattern, std::uint32_t frame) {
  const std::size_t begin = pattern.find(kPlace);
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::usage, fmt::format("'{} {}' {}; with --frames write for example {}.", option,
                                              text::printable(pattern, 200), why, "frame-####.exr"));
  };
  if (begin == std::string::npos) refuse("has no place for the number of the frame");
  const std::size_t end = std::min(pattern.find_first_not_of(kPlace, begin), pattern.size());
  if (pattern.find(kPlace, end) != std::string::npos) refuse("has two places for the number of the frame");
  return fmt::format("{}{:0{}}{}", pattern.substr(0, begin), frame, end - begin, pattern.substr(end));
}

bool is_finished(const std::vector<FrameFile>& files, const FilmHeader& wanted) {
  return std::ranges::all_of(files, [&](const FrameFile& file) { return is_finished_file(file, wanted); });
}

}  // namespace etendue::cli
