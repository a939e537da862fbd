#pragma once
/// Reads Nori's XML dialect, with Etendue's additions, as described in docs/scene_format.md, into plain structs.

#include <functional>
#include <optional>
#include <string>

#include "formats/mesh_formats.h"
#include "formats/read_options.h"
#include "formats/xml/xml_document.h"
#include "scene/diagnostics.h"
#include "scene/scene_file.h"

namespace etendue {

/// Loads a mesh file named in a scene, as MeshFormat::read does.
using MeshLoader = std::function<std::optional<TriangleMesh>(const MeshFormat&, const std::string& path,
                                                             const MeshContent&, Diagnostics& diagnostics)>;

/// Reads from memory: `file` names the text in messages and gives the folder that filenames are relative to.
std::optional<SceneFile> parse_scene_file(std::string text, const std::string& file, const ReadOptions& options,
                                          const MeshLoader& load_mesh, Diagnostics& diagnostics);
/// The same for a document; nothing if parsing it ended with a syntax error.
std::optional<SceneFile> read_nori(const XmlDocument& document, const ReadOptions& options, const MeshLoader& load_mesh,
                                   Diagnostics& diagnostics);

}  // namespace etendue
