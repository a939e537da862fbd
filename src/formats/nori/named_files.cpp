#include "formats/nori/named_files.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/printable.h"
#include "core/text.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMade = "etendue:";
constexpr const char* kVariable = "ETENDUE_MESHES";
constexpr const char* kFromProgram = "../share/etendue/meshes";  // scenes/CMakeLists.txt puts them there
constexpr std::size_t kMostShown = 300;                          // characters of a path

std::string shown(const fs::path& path) {
  return text::printable(path.string(), kMostShown);
}

bool is_there(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(path, unknown);
}

/// "etendue:bust.obj" for each file there is.
std::vector<std::string> made_names(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    names.push_back(std::string(kMade) + entry->path().filename().string());
  std::ranges::sort(names);
  return names;
}

/// How the files in that folder come into being.
std::string how_made(const fs::path& folder) {
  const fs::path build = (folder / "../../..").lexically_normal().parent_path();
  if (is_there(build / "CMakeCache.txt"))
    return fmt::format("'cmake --build {} --target scenes' makes all such files", shown(build));
  return fmt::format(
      "set {} to share/etendue/meshes of an installation, or of a build folder, where "
      "'cmake --build FOLDER --target scenes' makes the files",
      kVariable);
}

}  // namespace

fs::path made_files_folder() {
  if (const char* given = std::getenv(kVariable); given != nullptr && *given != '\0') return given;
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
  // Without /proc a folder that does not exist, rather than one relative to the working directory.
  const fs::path folder = unknown ? fs::path("/") : program.parent_path();
  return (folder / kFromProgram).lexically_normal();
}

NamedFiles::NamedFiles(const std::string& scene, Diagnostics& diagnostics)
    : folder_(fs::path(scene).parent_path()), sink_(diagnostics) {}

fs::path NamedFiles::find(const std::string& filename, const char* what, const SourcePosition& position) {
  if (filename.starts_with(kMade)) return find_made(std::string_view(filename).substr(kMade.size()), position);
  fs::path path = find_beside(filename, position);
  note_if_outside(path, what, position);
  return path;
}

fs::path NamedFiles::find_made(std::string_view name, const SourcePosition& position) {
  // Nothing but files of that folder, because the scene may come from a stranger.
  if (name.empty() || name.front() == '.' || name.find_first_of("/\\") != std::string_view::npos) {
    sink_.error(position, fmt::format("{} cannot follow \"{}\"; give the name of a file that Etendue's build makes, "
                                      "without folders, such as \"{}bust.obj\"",
                                      text::quoted(name), kMade, kMade));
    return {};
  }
  fs::path path = made_files_folder() / name;
  if (is_there(path) && noted_.emplace(name).second)
    sink_.note(position, fmt::format("{} is {}", text::quoted(fmt::format("{}{}", kMade, name)), shown(path)));
  return path;
}

fs::path NamedFiles::find_beside(const std::string& filename, const SourcePosition& position) {
  if (filename.find('\\') == std::string::npos || is_there(folder_ / filename)) return folder_ / filename;
  std::string slashed = filename;
  std::ranges::replace(slashed, '\\', '/');
  sink_.note(position, fmt::format("{} is read as {}", text::quoted(filename), text::quoted(slashed)));
  return folder_ / slashed;
}

/// A scene from a stranger may name any file of the machine; reading it is allowed, but reported.
void NamedFiles::note_if_outside(const fs::path& path, const char* what, const SourcePosition& position) {
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(fs::absolute(folder_.empty() ? "." : folder_, error), error);
  if (error) return;
  const fs::path target = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) return;
  const fs::path relative = target.lexically_relative(folder);
  const bool outside = relative.empty() || *relative.begin() == "..";
  if (outside)
    sink_.note(position,
               fmt::format("{} {} is outside the folder of the scene file", what, text::quoted(target.string())));
}

std::string NamedFiles::remedy(const std::string& filename, const fs::path& path) const {
  std::error_code unknown;
  if (fs::exists(path, unknown) || unknown) return "";
  const fs::path made = made_files_folder();
  if (filename.starts_with(kMade))
    return fmt::format("; {}{}", how_made(made), text::did_you_mean(filename, made_names(made)));
  std::string out = "; names are relative to the folder of the scene file";
  // The name of a made file without its prefix.
  const fs::path name = path.filename();
  if (is_there(made / name))
    out += fmt::format(", and \"{}{}\" is the file that Etendue's build makes", kMade, shown(name));
  return out;
}

}  // namespace etendue
