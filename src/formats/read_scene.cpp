#include "formats/read_scene.h"

#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/camera_option.h"
#include "formats/gltf/gltf_reader.h"
#include "formats/mesh_formats.h"
#include "formats/mitsuba/mitsuba_reader.h"
#include "formats/model/model_reader.h"
#include "formats/nori/nori_reader.h"
#include "formats/scene_text.h"
#include "formats/xml/xml_document.h"
#include "scene/check.h"
#include "scene/invariants.h"

namespace etendue {
namespace {

/// " 3.0.0" or nothing.
std::string version_of(const XmlElement& root) {
  const XmlAttribute* version = root.find("version");
  return version == nullptr ? "" : " " + version->value;
}

void set_environment(const std::string& path, Scene& scene, Diagnostics& diagnostics) {
  try {
    Bitmap bitmap = read_bitmap(path);
    if (const std::size_t count = clear_negative_values(bitmap); count > 0)
      diagnostics.warning({path, 0, 0}, fmt::format("the picture has {} negative values; they are taken as 0", count));
    scene.sky = {.picture = SkyPicture{.bitmap = std::make_shared<const Bitmap>(std::move(bitmap))}};
  } catch (const Error& error) {
    diagnostics.error({}, fmt::format("--environment: {}", error.what()), error.kind());
  }
}

/// What the caller adds to a scene, whatever its format.
void apply_additions(SceneFile& file, const ReadOptions& options, Diagnostics& diagnostics) {
  auto* scene = std::get_if<Scene>(&file);
  if (options.at) {
    if (scene == nullptr || scene->camera.path.empty())
      return diagnostics.error({}, "--at: nothing in this file moves; its camera has no keyframes", ErrorKind::usage);
    scene->camera.world_from_camera = pose_at(scene->camera.path, *options.at);
    scene->camera.path.keys.clear();
  }
  if (scene == nullptr || (options.environment.empty() && options.camera.empty())) return;
  if (!options.environment.empty()) set_environment(options.environment, *scene, diagnostics);
  if (!options.camera.empty()) set_camera(options.camera, *scene, diagnostics);
  if (!diagnostics.has_errors()) check_invariants(*scene, diagnostics);
}

/// What only some formats know, and this file is none of them.
void refuse_options(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics) {
  const auto refuse = [&](const char* option) {
    diagnostics.error({}, fmt::format("{}: only glTF assets have it, and {} is not one", option, path),
                      ErrorKind::usage);
  };
  if (!options.scene.empty()) refuse("--scene");
  if (!options.animation.empty()) refuse("--animation");
  if (!options.variant.empty()) refuse("--variant");
  if (options.lamps != GltfLamps::automatic) refuse("--lamps");
}

/// Models and assets: what has no properties.
std::optional<SceneFile> read_model_file(const std::string& path, const ReadOptions& options,
                                         Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  const bool asset = is_gltf(path);
  for (const auto& [name, value] : options.overrides)
    diagnostics.error({fmt::format("-D {}={}", name, value), 0, 0},
                      fmt::format("{} is {} without properties; write a scene with etendue convert", path,
                                  asset ? "a glTF asset" : "a mesh"),
                      ErrorKind::usage);
  if (!asset) refuse_options(path, options, diagnostics);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  std::optional<Scene> scene = asset ? read_gltf(path, options, diagnostics) : read_model(path, options, diagnostics);
  if (!scene) return std::nullopt;
  std::optional<SceneFile> file = std::move(*scene);
  ReadOptions additions = options;
  if (asset) additions.at.reset();  // is in the asset's nodes
  if (asset && !is_camera_placement(options.camera)) additions.camera = "";
  apply_additions(*file, additions, diagnostics);
  return diagnostics.error_count() > errors_before ? std::nullopt : std::move(file);
}

}  // namespace

std::optional<SceneFile> read_scene_file(const std::string& path, const ReadOptions& options,
                                         Diagnostics& diagnostics) {
  if (is_model(path) || is_gltf(path)) return read_model_file(path, options, diagnostics);
  refuse_options(path, options, diagnostics);
  std::string text;
  try {
    text = read_scene_text(path);
  } catch (const Error& error) {
    diagnostics.error({}, error.what(), error.kind());
    return std::nullopt;
  }
  const std::size_t errors_before = diagnostics.error_count();
  auto document = std::make_unique<XmlDocument>(std::move(text), path, diagnostics);
  if (!document->root()) return std::nullopt;
  std::optional<SceneFile> file;
  if (is_mitsuba(*document->root())) {
    diagnostics.note(document->position(document->root()->offset),
                     fmt::format("read as a scene for Mitsuba{}", version_of(*document->root())));
    file = parse_mitsuba_scene(std::move(document), options, mitsuba_files(), diagnostics);
  } else {
    file = read_nori(*document, options, read_mesh_file, diagnostics);
  }
  if (file && diagnostics.error_count() == errors_before) apply_additions(*file, options, diagnostics);
  return diagnostics.error_count() > errors_before ? std::nullopt : std::move(file);
}

SceneFile read_scene_file(const std::string& path, const ReadOptions& options) {
  Diagnostics diagnostics;
  std::optional<SceneFile> file = read_scene_file(path, options, diagnostics);
  if (file) check_scene_file(*file, diagnostics);
  diagnostics.log_warnings();
  diagnostics.throw_first_error();
  return std::move(*file);
}

Scene read_scene(const std::string& path, const ReadOptions& options) {
  SceneFile file = read_scene_file(path, options);
  if (auto* scene = std::get_if<Scene>(&file)) return std::move(*scene);
  const char* command = std::holds_alternative<TTest>(file) ? "ttest" : "chi2";
  throw Error(ErrorKind::scene,
              fmt::format("{}: the file holds a <test>, not a <scene>; run it with etendue {}", path, command));
}

}  // namespace etendue
