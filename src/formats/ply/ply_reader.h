#pragma once
/// PLY files, read as a stream. No library of Debian 12 reads them: there is none with a package of its own, and those
/// that programs carry along trust the counts in the header.

#include <optional>
#include <string>

#include "formats/byte_source.h"
#include "formats/mesh/mesh_content.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// Reads the elements `vertex`, `face` and `tristrips`, in any order and with their properties in any order, ASCII or
/// binary of either byte order, into one mesh in object space; all else is passed over. Polygons are triangulated,
/// vertices no face uses are left out. Colours of integer types are taken for sRGB, of float types for linear. Where
/// v = 0 lies the format does not say. Memory is spent only for what the file holds, whatever its header announces;
/// `bytes` is its size, where it is known.
std::optional<TriangleMesh> read_ply(const std::string& path, const MeshContent& content, Diagnostics& diagnostics);
/// The same from any source of bytes; `file` is for messages.
std::optional<TriangleMesh> read_ply(const ByteSource& source, const std::string& file, const MeshContent& content,
                                     Diagnostics& diagnostics, std::uint64_t bytes = 0);

}  // namespace etendue
