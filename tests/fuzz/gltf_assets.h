#pragma once
/// For the targets that read glTF assets: any bytes must give a valid scene or an error.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/errors.h"
#include "formats/gltf/gltf_reader.h"
#include "meshes.h"
#include "scene/check.h"

namespace etendue::fuzz {

/// A URI names a file of a few bytes or one that does not exist.
inline void read_any_asset(std::vector<std::byte> bytes) {
  const bool approximate = bytes.size() % 2 == 0;
  // An asset with animations is shown at a time between keyframes or after them.
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::optional<double> at;
  if (text.find("animations") != std::string_view::npos) at = 0.375 * static_cast<double>(bytes.size() % 7);
  const GltfFileOpener open = [](const std::string& uri) {
    if (uri.size() % 3 == 0) throw Error(ErrorKind::file, "there is no such file");
    return memory_store(std::vector<std::byte>(uri.size(), std::byte{7}));
  };
  Diagnostics diagnostics;
  const std::optional<Scene> scene =
      read_gltf(memory_store(std::move(bytes)), "fuzz.gltf", open, {.approximate = approximate, .at = at}, diagnostics);
  require(scene.has_value() != diagnostics.has_errors());
  for (const Diagnostic& d : diagnostics.list())
    require(!d.message.empty() && d.message.find('\n') == std::string::npos);
  if (!scene) return;
  for (const Shape& shape : scene->shapes) require_sound(std::get<TriangleMesh>(shape));
  check_scene(*scene, diagnostics);
  scene_hash(*scene);
}

}  // namespace etendue::fuzz
