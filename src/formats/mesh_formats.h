#pragma once
/// The kinds of mesh files: a new one is a reader in a folder of its own and a row here. Every dialect of scene files
/// offers all of them as <mesh type="…">.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/mesh/mesh_content.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

struct MeshFormat {
  const char* word;   ///< the extension of its files, and the type of their <mesh>
  const char* title;  ///< "OBJ", for messages
  const char* doc;    ///< for docs/scene_format.md
  bool states_v;      ///< the format says where v = 0 lies, and `read` gives v upward as scene.h does
  /// One mesh in object space; nothing after reporting an error. Throws Error if the file cannot be opened or read. A
  /// file without triangles gives a mesh without them.
  std::optional<TriangleMesh> (*read)(const std::string& path, const MeshContent& content, Diagnostics& diagnostics);
};

const std::vector<MeshFormat>& mesh_formats();
/// The format of an extension, or nullptr.
const MeshFormat* find_mesh_format(std::string_view word);

/// What `format.read` reads, as a function: the way in of readers of scenes, which tests fill from memory.
std::optional<TriangleMesh> read_mesh_file(const MeshFormat& format, const std::string& path,
                                           const MeshContent& content, Diagnostics& diagnostics);

}  // namespace etendue
