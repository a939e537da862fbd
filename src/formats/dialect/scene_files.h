#pragma once
/// The files that a scene file names, written beside it: meshes and pictures.

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "scene/scene.h"

namespace etendue {

class SceneFiles {
 public:
  /// Files of the scene file at `path` go into the folder NAME-files beside it, which is made when the first one is
  /// written.
  explicit SceneFiles(const std::string& path);

  // Names relative to the folder of the scene file; what was written before has its name already. Throw Error(file).
  std::string mesh(const Scene& scene, std::uint32_t shape);
  std::string picture(const std::shared_ptr<const Bitmap>& bitmap);

 private:
  std::string name_of(const std::string& file);
  std::string path_of(const std::string& name) const;

  std::string folder_;  ///< of the scene file
  std::string files_;   ///< relative to it
  bool made_ = false;
  std::map<std::uint32_t, std::string> meshes_;
  std::map<const Bitmap*, std::string> pictures_;
};

}  // namespace etendue
