#include "formats/dialect/scene_files.h"

#include <filesystem>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/ply/ply_writer.h"
#include "image/bitmap_file.h"

namespace etendue {

namespace fs = std::filesystem;

SceneFiles::SceneFiles(const std::string& path)
    : folder_(fs::path(path).parent_path().string()), files_(fs::path(path).stem().string() + "-files") {}

std::string SceneFiles::path_of(const std::string& name) const {
  return (fs::path(folder_) / name).string();
}

std::string SceneFiles::name_of(const std::string& file) {
  if (!made_) {
    std::error_code error;
    fs::create_directories(path_of(files_), error);
    if (error)
      throw Error(ErrorKind::file, fmt::format("{}: cannot make the folder: {}", path_of(files_), error.message()));
    made_ = true;
  }
  return files_ + "/" + file;
}

std::string SceneFiles::mesh(const Scene& scene, std::uint32_t shape) {
  const auto [known, is_new] = meshes_.try_emplace(shape);
  if (!is_new) return known->second;
  known->second = name_of(fmt::format("mesh-{}.ply", meshes_.size() - 1));
  write_ply(path_of(known->second), std::get<TriangleMesh>(scene.shapes[shape]));
  return known->second;
}

std::string SceneFiles::picture(const std::shared_ptr<const Bitmap>& bitmap) {
  const auto [known, is_new] = pictures_.try_emplace(bitmap.get());
  if (!is_new) return known->second;
  known->second = name_of(fmt::format("picture-{}.{}", pictures_.size() - 1, bitmap_extension(*bitmap)));
  write_bitmap(path_of(known->second), *bitmap);
  return known->second;
}

}  // namespace etendue
