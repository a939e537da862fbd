#pragma once
/// Shapes of a Mitsuba scene, alone or in groups that are shown several times, as instances of a Scene.

#include <compare>
#include <map>

#include "formats/mitsuba/mitsuba_files.h"
#include "formats/mitsuba/mitsuba_materials.h"

namespace etendue {

class MitsubaShapes {
 public:
  MitsubaShapes(const MitsubaContext& context, const MitsubaFiles& files, MitsubaMaterials& materials, Scene& scene)
      : context_(context), files_(files), materials_(materials), scene_(scene) {}

  /// A <shape> of the scene itself: its instances, which a group has none of.
  void add(const XmlElement& element);
  /// Says what is wrong with all of them together.
  void finish();

 private:
  /// What decides about a mesh: who asks for the same gets the same.
  struct MeshKey {
    std::string path;
    std::int64_t index;
    bool face_normals, flip_tex_coords;
    auto operator<=>(const MeshKey&) const = default;
  };

  std::optional<Instance> read(const MitsubaObject& object);
  /// Row of Scene::shapes.
  std::optional<std::uint32_t> read_geometry(const MitsubaObject& object, std::string& name);
  /// `format` is null for `serialized`.
  std::optional<std::uint32_t> read_mesh(const MitsubaObject& object, const MeshFormat* format, std::string& name);
  /// `key.face_normals` becomes true where the file says so itself.
  std::optional<TriangleMesh> load(const MeshFormat* format, MeshKey& key, const SourcePosition& position);
  std::optional<TriangleMesh> open(const MeshFormat* format, MeshKey& key);
  std::optional<std::uint32_t> read_emitter(const MitsubaObject& object);
  void add_group_instance(const MitsubaObject& object);
  const std::vector<Instance>& group(const XmlElement& element);
  void add(Instance instance);
  std::uint32_t add_shape(Shape shape);
  bool exceeds(std::uintmax_t sum, std::uintmax_t limit, const char* what, const SourcePosition& position);

  const MitsubaContext& context_;
  const MitsubaFiles& files_;
  MitsubaMaterials& materials_;
  Scene& scene_;
  std::map<MeshKey, std::optional<std::uint32_t>> meshes_;
  std::optional<std::uint32_t> rectangle_, cube_;
  std::map<const XmlElement*, std::vector<Instance>> groups_;
  std::size_t triangles_ = 0, vertices_ = 0;
  std::uintmax_t mesh_bytes_ = 0;
  bool too_much_ = false;
};

}  // namespace etendue
