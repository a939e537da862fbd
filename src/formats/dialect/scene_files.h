#pragma once
/// A scene file being written, with the files that it names: meshes and pictures next to it.

#include <compare>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "scene/scene.h"

namespace etendue {

/// What to do with existing files.
enum class ExistingFiles { refuse, replace };

class SceneFiles {
 public:
  /// Files of the scene file at `path` go into the folder NAME-files next to it. The scene must outlive this.
  SceneFiles(const std::string& path, const Scene& scene) : path_(path), scene_(scene) {}

  // Names relative to the folder of the scene file; nothing is written yet.
  /// `uv_set`: which of its sets of texture coordinates the file holds; `turned`: with its sides exchanged.
  std::string mesh(std::uint32_t shape, std::uint32_t uv_set, bool turned = false);
  std::string picture(const std::shared_ptr<const Bitmap>& bitmap);
  /// Lets a picture keep the name that it already has.
  void know(const std::shared_ptr<const Bitmap>& bitmap, const std::string& name);

  /// Writes them, and then `text` as the scene file, once everything that it names exists. Throws Error(file), after
  /// removing the files that it has created.
  void write(const std::string& text, ExistingFiles existing) const;

 private:
  std::string folder() const;  ///< NAME-files

  std::string path_;
  const Scene& scene_;
  struct MeshKey {
    std::uint32_t shape, uv_set;
    bool turned;
    auto operator<=>(const MeshKey&) const = default;
  };
  std::map<MeshKey, std::string> meshes_;
  std::map<std::shared_ptr<const Bitmap>, std::string>
      pictures_;  ///< kept, so that no other comes to lie where one was
};

}  // namespace etendue
