#pragma once
/// Mitsuba's own meshes, `.serialized`: several in one file, each a compressed stream of its own, with a table of
/// their places at the end.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

struct SerializedMesh {
  TriangleMesh mesh;
  bool face_normals = false;  ///< the file wants its triangles flat, whatever normals it has
};

/// One mesh of a file, counted from 0; v of its texture coordinates as the file has it. Nothing after reporting an
/// error. Throws Error if the file cannot be opened or read.
std::optional<SerializedMesh> read_serialized(const std::string& path, std::int64_t index, Diagnostics& diagnostics);
/// The same of the bytes of a file; `file` is for messages.
std::optional<SerializedMesh> read_serialized(std::span<const std::byte> bytes, const std::string& file,
                                              std::int64_t index, Diagnostics& diagnostics);

}  // namespace etendue
