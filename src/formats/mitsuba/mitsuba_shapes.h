#pragma once
/// Turns shapes of a Mitsuba scene, and groups of shapes, into instances of a Scene.

#include <compare>
#include <map>

#include "formats/mitsuba/mitsuba_files.h"
#include "formats/mitsuba/mitsuba_materials.h"

namespace etendue {

class MitsubaShapes {
 public:
  MitsubaShapes(const MitsubaContext& context, const MitsubaFiles& files, MitsubaMaterials& materials,
                MitsubaTextures& textures, Scene& scene)
      : context_(context), files_(files), materials_(materials), textures_(textures), scene_(scene) {}

  /// Adds the instances of a <shape> in the scene; a group by itself has none.
  void add(const XmlElement& element);
  /// Reports what is wrong with all shapes together.
  void finish();

 private:
  /// Everything that a loaded mesh depends on: shapes with equal keys share a mesh.
  struct MeshKey {
    std::string path;
    std::int64_t index;
    bool face_normals, flip_tex_coords, uv, textured, colors;
    std::string attribute;
    auto operator<=>(const MeshKey&) const = default;
  };

  /// A row of Scene::shapes, and whether its normals follow from the winding in world space, which mirroring reverses.
  struct Geometry {
    std::uint32_t shape = 0;
    bool normals_by_winding = false;
  };

  std::optional<Instance> read(const MitsubaObject& object);
  std::optional<Geometry> read_geometry(const MitsubaObject& object, const MeshContent& content, Instance& instance);
  /// `to_world` may stretch a cylinder along its axis, which only changes its height.
  std::optional<Geometry> read_cylinder(const MitsubaObject& object, Instance& instance);
  /// `format` is null for `serialized`.
  std::optional<Geometry> read_mesh(const MitsubaObject& object, const MeshFormat* format, const MeshContent& content,
                                    std::string& name);
  /// Sets `key.face_normals` if the file itself asks for flat triangles.
  std::optional<TriangleMesh> load(const MeshFormat* format, MeshKey& key, const SourcePosition& position);
  std::optional<TriangleMesh> open(const MeshFormat* format, MeshKey& key);
  void set_coordinates(const MeshKey& key, const SourcePosition& position, TriangleMesh& mesh);
  std::optional<std::uint32_t> read_emitter(const MitsubaObject& object);
  void add_all(const MitsubaObject& object);
  void add_group_instance(const MitsubaObject& object);
  const std::vector<Instance>& group(const XmlElement& element);
  void add(Instance instance);
  void report_too_many(const SourcePosition& position);
  Geometry add_shape(Shape shape, bool normals_by_winding = false);
  bool exceeds(std::uintmax_t sum, std::uintmax_t limit, const char* what, const SourcePosition& position);

  const MitsubaContext& context_;
  const MitsubaFiles& files_;
  MitsubaMaterials& materials_;
  MitsubaTextures& textures_;
  Scene& scene_;
  std::map<MeshKey, std::optional<Geometry>> meshes_;
  std::optional<Geometry> rectangle_, cube_, disk_;
  std::map<const XmlElement*, std::vector<Instance>> groups_;
  std::size_t triangles_ = 0, vertices_ = 0;
  std::uintmax_t mesh_bytes_ = 0;
  std::size_t visited_ = 0;
  int merges_ = 0;  ///< nesting depth of those being read
  bool too_much_ = false;
};

}  // namespace etendue
