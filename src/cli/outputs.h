#pragma once
/// Files that a command writes: checked before the work begins, written one by one at its end.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/command_line.h"
#include "core/errors.h"
#include "image/image.h"

namespace etendue::cli {

/// Throws Error(usage) unless the path ends in .exr or .png.
void check_output_name(const std::string& path);

/// Throws Error(file) if the file could not be written now; to be called before the work rather than after it. Does not
/// touch the file.
void check_writable(const std::string& path);

/// An option and the file it names: {"-o", "picture.exr"}.
using NamedFile = std::pair<std::string, std::string>;

/// Throws Error(usage) if two of the names lead to the same file, through symbolic or hard links. Empty names are
/// skipped.
void check_distinct(const std::vector<NamedFile>& files);

/// --oidn, and in commands that render --denoise.
struct DenoiseOptions {
  bool wanted = false;
  std::string library;

  /// Adds --oidn.
  void add_to(Command& command);
  /// Adds both.
  void add_with_flag(Command& command);
};

/// --tonemap and --exposure: how PNG files show the picture.
struct DisplayOptions {
  std::string tone_map = "none";
  double exposure = 0.0;

  void add_to(Command& command);
  Display display() const;
  /// Throws Error(usage) if one of them was given but none of the outputs is a PNG file.
  void check(const std::vector<std::string>& outputs) const;
};

/// "picture.denoised.exr" for "picture.exr".
std::string denoised_name(const std::string& path);

/// For a name that is not a film's: writes a picture, as .exr or, converted by `display`, as .png.
void write_picture(const std::string& path, const Image& image, const Display& display);

/// Writes a film as a picture (.png, converted by `display`), or as a picture or film (.exr).
void write_output(const std::string& path, const FilmFile& film, bool as_film, const Display& display);

/// Writes files one by one; a failure does not prevent the others from being written.
class OutputWriter {
 public:
  /// Calls `write`, which writes the file at `path`; an Error(file) or a lack of memory is kept for finish().
  void write(const std::string& path, const std::function<void()>& write);
  /// The same, if `write` chooses the path and returns it.
  void write_somewhere(const std::string& path, const std::function<std::string()>& write);

  const std::vector<std::string>& written() const { return written_; }
  const std::vector<std::string>& failed() const { return failed_; }
  /// Takes over the failures of another writer.
  void add_failures(const OutputWriter& other);
  /// One sentence about everything that failed; empty if nothing did.
  std::string complaint() const;
  /// Throws Error(file) with the complaint if there is one.
  void finish() const;

 private:
  std::vector<std::string> written_, failed_, reasons_;
};

}  // namespace etendue::cli
