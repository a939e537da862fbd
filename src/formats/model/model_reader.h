#pragma once
/// A mesh file on its own as a scene: seen from a camera framed on it, under a soft sky.

#include <optional>
#include <string>

#include "formats/read_options.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// Whether a path is that of a bare mesh: by its extension, .obj or .ply.
bool is_model(const std::string& path);

/// The scene of an OBJ file, with the materials of its libraries, or of a PLY file, with its colours. Says what it
/// added and what it left out. Nothing after an error.
std::optional<Scene> read_model(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics);

}  // namespace etendue
