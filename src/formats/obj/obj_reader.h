#pragma once
/// Wavefront OBJ files, read as a stream. tinyobjloader is not used, because it reports errors without positions,
/// accepts indices out of range and has crashed on hostile files.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/byte_source.h"
#include "formats/mesh/mesh_content.h"
#include "scene/diagnostics.h"
#include "scene/limits.h"
#include "scene/scene.h"

namespace etendue {

/// Bounds on a file beside those of scene/limits.h and mesh_content.h, so that memory stays within a few GiB whatever
/// the file contains.
struct ObjLimits {
  static constexpr std::size_t kMaxLine = std::size_t{4} << 20;  ///< bytes, continuations included
};

/// The materials of a file, and the one of each triangle.
struct ObjMaterials {
  std::vector<std::string> libraries;          ///< of `mtllib`, as the file names them
  std::vector<std::string> names;              ///< of `usemtl`; the first is "", of faces before any
  std::vector<std::uint32_t> of_triangle;      ///< indices into the names
  static constexpr std::size_t kMost = 65536;  ///< of either
};

/// Reads `v`, `vt`, `vn` and `f` lines into one mesh in object space; groups, materials and smoothing groups are
/// ignored. Polygons are triangulated, corners of a vertex that differ in normal or texture coordinates become vertices
/// of their own, vertices no face uses are left out. Where only some faces have normals, the others get that of their
/// plane. Colours (`v x y z r g b`, in [0,1]) are taken for sRGB. Lines with errors are reported, with line and column,
/// and skipped, up to 20 of them; then there is no mesh. A vertex or normal that is wrong and that no face uses is a
/// warning; so is anything wrong with texture coordinates or colours, of which the mesh has none then. A file without
/// faces gives a mesh without triangles, not an error: what that means is up to the caller. Warnings are reported too.
std::optional<TriangleMesh> read_obj(const std::string& path, const MeshContent& content, Diagnostics& diagnostics);
/// The same with the names of materials.
std::optional<TriangleMesh> read_obj(const std::string& path, const MeshContent& content, ObjMaterials& materials,
                                     Diagnostics& diagnostics);
/// The same from any source of bytes; `file` is for messages.
std::optional<TriangleMesh> read_obj(const ByteSource& source, const std::string& file, const MeshContent& content,
                                     Diagnostics& diagnostics, ObjMaterials* materials = nullptr);

}  // namespace etendue
