#pragma once
/// The one door for files: a scene or a test, whatever its format, as a checked `Scene`.

#include <optional>
#include <string>

#include "formats/read_options.h"
#include "scene/diagnostics.h"
#include "scene/scene_file.h"

namespace etendue {

/// Reads a file and reports every problem it can find in one pass; nothing if there is an error. Never throws for what
/// a file holds.
std::optional<SceneFile> read_scene_file(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics);

/// Reads a file, logs its warnings, and throws Error with the first error (scene; usage for a bad override;
/// file if reading fails half-way).
SceneFile read_scene_file(const std::string& path, const ReadOptions& options = {});
/// The same for a file that must hold a <scene>; a test file is an error that names the command for it.
Scene read_scene(const std::string& path, const ReadOptions& options = {});

}  // namespace etendue
