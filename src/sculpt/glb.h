#pragma once
/// Binary glTF: meshes with normals and texture coordinates, materials, pictures and nodes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/json.h"
#include "sculpt/mesh.h"

namespace etendue::sculpt {

/// Collects what a file contains; each `add` returns the number by which other parts refer to it.
class Glb {
 public:
  /// The mesh needs a normal for each position; it is shown with that material.
  std::size_t add_mesh(const Mesh& mesh, std::size_t material);
  std::size_t add_material(Json material) { return add("materials", std::move(material)); }
  std::size_t add_node(Json node) { return add("nodes", std::move(node)); }
  /// A texture from the bytes of a PNG file. It repeats.
  std::size_t add_texture(std::span<const std::byte> png);
  /// Any member of the file's top level.
  Json& operator[](const char* name) { return json_[name]; }

  /// Completely or not at all.
  void write(const std::string& path);

 private:
  std::size_t add(const std::string& list, Json element);
  std::size_t add_view(std::span<const std::byte> bytes);
  std::size_t add_accessor(std::span<const std::byte> bytes, Json properties);

  Json json_;
  std::map<std::string, std::size_t> sizes_;  ///< of the lists
  std::vector<std::byte> buffer_;
};

}  // namespace etendue::sculpt
