#include "formats/dialect/scene_files.h"

#include <filesystem>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/ply/ply_writer.h"
#include "image/bitmap_file.h"
#include "image/files.h"

namespace etendue {

namespace fs = std::filesystem;

namespace {

void turn_inside_out(TriangleMesh& mesh) {
  for (glm::uvec3& triangle : mesh.triangles) std::swap(triangle.y, triangle.z);
  for (glm::dvec3& normal : mesh.normals.edit()) normal = -normal;
}

void write_mesh(const std::string& path, const TriangleMesh& mesh, std::uint32_t uv_set, bool turned) {
  if (mesh.uv_sets.size() <= 1 && !turned) return write_ply(path, mesh);
  TriangleMesh written = mesh;
  if (mesh.uv_sets.size() > 1) written.uv_sets = {mesh.uv_sets[uv_set]};
  if (turned) turn_inside_out(written);
  write_ply(path, written);
}

}  // namespace

std::string SceneFiles::folder() const {
  return fs::path(path_).stem().string() + "-files";
}

std::string SceneFiles::mesh(std::uint32_t shape, std::uint32_t uv_set, bool turned) {
  const auto [known, is_new] = meshes_.try_emplace({shape, uv_set, turned});
  if (is_new) known->second = fmt::format("{}/mesh-{}.ply", folder(), meshes_.size() - 1);
  return known->second;
}

std::string SceneFiles::picture(const std::shared_ptr<const Bitmap>& bitmap) {
  const auto [known, is_new] = pictures_.try_emplace(bitmap);
  if (is_new)
    known->second = fmt::format("{}/picture-{}.{}", folder(), pictures_.size() - 1, bitmap_extension(*bitmap));
  return known->second;
}

void SceneFiles::know(const std::shared_ptr<const Bitmap>& bitmap, const std::string& name) {
  pictures_.try_emplace(bitmap, name);
}

void SceneFiles::write(const std::string& text, ExistingFiles existing) const {
  const fs::path beside = fs::path(path_).parent_path();
  std::vector<std::pair<std::string, std::function<void(const std::string& path)>>> files;
  for (const auto& [key, name] : meshes_) {
    const auto& mesh = std::get<TriangleMesh>(scene_.shapes[key.shape]);
    files.emplace_back((beside / name).string(),
                       [&mesh, key = key](const std::string& path) { write_mesh(path, mesh, key.uv_set, key.turned); });
  }
  for (const auto& [bitmap, name] : pictures_)
    files.emplace_back((beside / name).string(),
                       [&bitmap = *bitmap](const std::string& path) { write_bitmap(path, bitmap); });
  files.emplace_back(path_,
                     [&](const std::string& path) { write_file_atomically(path, std::as_bytes(std::span(text))); });

  std::error_code error;
  std::vector<std::string> made;
  for (const auto& [path, write] : files) {
    if (!fs::exists(path, error)) {
      made.push_back(path);
    } else if (existing == ExistingFiles::refuse) {
      throw Error(ErrorKind::file, fmt::format("{}: exists already; --force replaces it", path));
    }
  }
  const fs::path files_folder = beside / folder();
  const bool made_folder = files.size() > 1 && fs::create_directory(files_folder, error);
  if (error)
    throw Error(ErrorKind::file, fmt::format("{}: cannot make the folder: {}", files_folder.string(), error.message()));
  try {
    for (const auto& [path, write] : files) write(path);
  } catch (...) {
    for (const std::string& path : made) fs::remove(path, error);
    if (made_folder) fs::remove(files_folder, error);
    throw;
  }
}

}  // namespace etendue
