#include "cli/outputs.h"

#include <algorithm>
#include <filesystem>
#include <new>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include "image/files.h"
#include "image/film_file.h"

namespace etendue::cli {

void check_output_name(const std::string& path) {
  if (path.ends_with(".exr") || path.ends_with(".png")) return;
  throw Error(ErrorKind::usage,
              fmt::format("'-o {}' ends neither in .exr nor in .png, the only formats for pictures.", path));
}

void check_writable(const std::string& path) {
  const AtomicFile probe(path);
}

void check_distinct(const std::vector<NamedFile>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const auto& [a_option, a] = files[k];
      const auto& [b_option, b] = files[i];
      if (a.empty() || b.empty() || !is_same_place(a, b)) continue;
      throw Error(ErrorKind::usage, fmt::format("'{} {}' and '{} {}' are the same file; give one of them another name.",
                                                a_option, a, b_option, b));
    }
  }
}

void DisplayOptions::add_to(Command& command) {
  command
      .add_option("--tonemap", tone_map,
                  "how PNG files show values brighter than white: none clips them, reinhard compresses the luminance, "
                  "aces is a filmic curve; EXR files keep the radiance")
      ->type_name("OPERATOR")
      ->check(one_of(tone_map_names()))
      ->capture_default_str();
  command.add_option("--exposure", exposure, "brightness of PNG files in stops: 1 doubles it, -1 halves it")
      ->type_name("STOPS")
      ->check(in_range(-60.0, 60.0))
      ->capture_default_str();
}

Display DisplayOptions::display() const {
  return {.tone_map = tone_map_of(tone_map), .exposure = exposure};
}

void DisplayOptions::check(const std::vector<std::string>& outputs) const {
  if (!display().changes_values()) return;
  if (std::ranges::any_of(outputs, [](const std::string& path) { return path.ends_with(".png"); })) return;
  throw Error(ErrorKind::usage,
              "--tonemap and --exposure change PNG files only, and none is written; add -o NAME.png.");
}

void DenoiseOptions::add_to(Command& command) {
  command
      .add_option("--oidn", library,
                  "the Open Image Denoise library to use instead of the system's libOpenImageDenoise.so.2")
      ->file({".so", ".so.2"});
}

void DenoiseOptions::add_with_flag(Command& command) {
  command.add_flag("--denoise", wanted,
                   "also write every output denoised, as NAME.denoised.exr next to NAME.exr; needs Open Image Denoise");
  add_to(command);
}

std::string denoised_name(const std::string& path) {
  std::filesystem::path name(path);
  const std::string ending = name.extension().string();
  name.replace_extension(".denoised" + ending);
  return name.string();
}

void write_picture(const std::string& path, const Image& image, const Display& display) {
  if (path.ends_with(".png")) {
    write_png(path, image, display);
  } else {
    write_exr(path, image);
  }
}

void write_output(const std::string& path, const FilmFile& film, bool as_film, const Display& display) {
  if (path.ends_with(".exr") && as_film) {
    write_film(path, film);
    return;
  }
  write_picture(path, image_from_film(film), display);
}

void OutputWriter::write(const std::string& path, const std::function<void()>& write) {
  write_somewhere(path, [&] {
    write();
    return path;
  });
}

void OutputWriter::write_somewhere(const std::string& path, const std::function<std::string()>& write) {
  try {
    written_.push_back(write());
    return;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::file) throw;
    reasons_.emplace_back(error.what());
  } catch (const std::bad_alloc&) {
    reasons_.push_back(fmt::format("{}: this machine has too little memory to write it", path));
  }
  failed_.push_back(path);
}

void OutputWriter::add_failures(const OutputWriter& other) {
  failed_.insert(failed_.end(), other.failed_.begin(), other.failed_.end());
  reasons_.insert(reasons_.end(), other.reasons_.begin(), other.reasons_.end());
}

std::string OutputWriter::complaint() const {
  return fmt::format("{}", fmt::join(reasons_, "; "));
}

void OutputWriter::finish() const {
  if (!failed_.empty()) throw Error(ErrorKind::file, complaint());
}

}  // namespace etendue::cli
