#include "view/snapshot.h"

#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/files.h"
#include "image/image.h"
#include "render/film_identity.h"

namespace etendue::view {
namespace {

/// A temporary folder, deleted at the end.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code error;
    path_ = (std::filesystem::temp_directory_path(error) / "etendue-view-XXXXXX").string();
    if (error || mkdtemp(path_.data()) == nullptr)
      throw Error(ErrorKind::file, fmt::format("{}: cannot make a folder: {}", path_, std::strerror(errno)));
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

std::string snapshot_bytes(const SnapshotFacts& facts, const Film& film, const std::string& extension,
                           const Display& display) {
  Scene shown = facts.scene;
  shown.materials = facts.materials;
  set_light_sources(shown, facts.lights);
  shown.camera = facts.camera;
  shown.integrator = facts.integrator;
  shown.aovs.clear();
  FilmFile file{film, film_identity(shown, facts.seed).metadata, {{0, facts.samples}}, {}};
  file.metadata["device"] = facts.device;
  file.metadata["driver"] = facts.driver;
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/picture" + extension;
  if (extension == ".exr") {
    write_exr(path, image_from_film(file));
  } else if (extension == ".png") {
    write_png(path, image_from_film(file), display);
  } else {
    throw Error(ErrorKind::usage, fmt::format("A snapshot can be .exr or .png, not '{}'.", extension));
  }
  const std::vector<std::byte> bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace etendue::view
