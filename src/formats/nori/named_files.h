#pragma once
/// Finds the files that a scene names: meshes and pictures.

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <string_view>

#include "scene/diagnostics.h"

namespace etendue {

/// The folder of the meshes and pictures that Etendue's build makes, which scenes name as "etendue:bust.obj": what the
/// environment variable ETENDUE_MESHES says, otherwise ../share/etendue/meshes as seen from the folder of the running
/// program, in build trees and installations alike.
std::filesystem::path made_files_folder();

class NamedFiles {
 public:
  /// `scene`: the path of the scene file.
  NamedFiles(const std::string& scene, Diagnostics& diagnostics);

  /// The path of a file, which need not exist. A name is relative to the folder of the scene file; if there is no file
  /// with the name as written, backslashes are treated as those of a Windows path. "etendue:NAME" is the file NAME in
  /// `made_files_folder()` and nowhere else, and a name without "etendue:" is never looked for there. `what` is "mesh"
  /// or "picture". Reports names that lead elsewhere than expected; empty after an error.
  std::filesystem::path find(const std::string& filename, const char* what, const SourcePosition& position);

  /// What would help if that file does not exist, to be appended to the message that says so; otherwise "".
  std::string remedy(const std::string& filename, const std::filesystem::path& path) const;

 private:
  std::filesystem::path find_made(std::string_view name, const SourcePosition& position);
  std::filesystem::path find_beside(const std::string& filename, const SourcePosition& position);
  void note_if_outside(const std::filesystem::path& path, const char* what, const SourcePosition& position);

  std::filesystem::path folder_;
  Diagnostics& sink_;
  std::set<std::string, std::less<>> noted_;  ///< names of made files whose place has been reported
};

}  // namespace etendue
