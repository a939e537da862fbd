#include "formats/mesh_formats.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/obj/obj_reader.h"

namespace etendue {

const std::vector<MeshFormat>& mesh_formats() {
  static const std::vector<MeshFormat> kFormats = {
      {"obj", "OBJ", "Triangles from a Wavefront OBJ file.", true,
       [](const std::string& path, Diagnostics& diagnostics) { return read_obj(path, diagnostics); }},
  };
  return kFormats;
}

const MeshFormat* find_mesh_format(std::string_view word) {
  for (const MeshFormat& format : mesh_formats()) {
    if (format.word == word) return &format;
  }
  return nullptr;
}

std::string mesh_format_titles() {
  std::vector<std::string> titles;
  for (const MeshFormat& format : mesh_formats()) titles.emplace_back(format.title);
  return fmt::format("{}", fmt::join(titles, " or "));
}

}  // namespace etendue
