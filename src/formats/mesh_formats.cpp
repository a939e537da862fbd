#include "formats/mesh_formats.h"

#include "formats/mesh/mesh_content.h"
#include "formats/obj/obj_reader.h"
#include "formats/ply/ply_reader.h"

namespace etendue {

const std::vector<MeshFormat>& mesh_formats() {
  static const std::vector<MeshFormat> kFormats = {
      {"obj", "OBJ", "Triangles from a Wavefront OBJ file.", true, read_obj},
      {"ply", "PLY", "Triangles from a PLY file, ASCII or binary.", false, read_ply},
  };
  return kFormats;
}

const MeshFormat* find_mesh_format(std::string_view word) {
  for (const MeshFormat& format : mesh_formats()) {
    if (format.word == word) return &format;
  }
  return nullptr;
}

std::optional<TriangleMesh> read_mesh_file(const MeshFormat& format, const std::string& path,
                                           const MeshContent& content, Diagnostics& diagnostics) {
  std::optional<TriangleMesh> mesh = format.read(path, content, diagnostics);
  if (mesh) narrow_vectors(*mesh);
  return mesh;
}

}  // namespace etendue
