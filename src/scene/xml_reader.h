#pragma once
/// Reading of scene and test files: XML in, validated plain structs out. The format is described in
/// docs/scene_format.md.

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

struct ReadOptions {
  /// "tag.property" and value, as given with -D: {"integrator.nee", "false"}. In a file of several scenes they apply to
  /// each.
  std::vector<std::pair<std::string, std::string>> overrides;
  /// Unknown properties are errors instead of warnings.
  bool strict = false;
};

/// What a file can hold.
using SceneFile = std::variant<Scene, TTest, Chi2Test>;

/// Reads a file and reports every problem it can find in one pass; nothing if there is an error. Never throws for what
/// a file holds.
std::optional<SceneFile> read_scene_file(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics);

/// Reads a file, logs its warnings, and throws Error with the first error (scene_error; usage for a bad override;
/// file_error if reading fails half-way).
SceneFile read_scene_file(const std::string& path, const ReadOptions& options = {});
/// The same for a file that must hold a <scene>; a test file is an error that names the command for it.
Scene read_scene(const std::string& path, const ReadOptions& options = {});

/// Loads the mesh of an OBJ file named in a scene; nothing after reporting an error.
using MeshLoader = std::function<std::optional<TriangleMesh>(
    const std::string& path, const glm::dmat4& world_from_object, Diagnostics& diagnostics)>;

/// Reads from memory: `file` names the text in messages and gives the folder that filenames are relative to.
std::optional<SceneFile> parse_scene_file(std::string text, const std::string& file, const ReadOptions& options,
                                          const MeshLoader& load_mesh, Diagnostics& diagnostics);

}  // namespace etendue
