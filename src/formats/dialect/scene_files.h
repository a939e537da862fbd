#pragma once
/// A scene file in the making, and the files that it names: meshes and pictures beside it.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "scene/scene.h"

namespace etendue {

/// What becomes of files that are there already.
enum class ExistingFiles { refuse, replace };

class SceneFiles {
 public:
  /// Files of the scene file at `path` go into the folder NAME-files beside it. The scene must outlive this.
  SceneFiles(const std::string& path, const Scene& scene) : path_(path), scene_(scene) {}

  // Names relative to the folder of the scene file; nothing is written yet.
  /// `turned`: with its inside out.
  std::string mesh(std::uint32_t shape, bool turned = false);
  std::string picture(const std::shared_ptr<const Bitmap>& bitmap);
  /// Gives a picture the name that it has already.
  void know(const std::shared_ptr<const Bitmap>& bitmap, const std::string& name);

  /// Writes them, and `text` as the scene file when all that it names is there. Throws Error(file); then files that
  /// this made are taken away again.
  void write(const std::string& text, ExistingFiles existing) const;

 private:
  std::string folder() const;  ///< NAME-files

  std::string path_;
  const Scene& scene_;
  std::map<std::pair<std::uint32_t, bool>, std::string> meshes_;  ///< by shape, and whether it is turned
  std::map<std::shared_ptr<const Bitmap>, std::string>
      pictures_;  ///< kept, so that no other comes to lie where one was
};

}  // namespace etendue
