#pragma once
/// Turns meshes of a glTF asset into shapes of a scene. A mesh that several nodes show is read once.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/gltf_nodes.h"
#include "formats/gltf/gltf_surfaces.h"
#include "formats/gltf/primitive.h"

namespace etendue {

/// A part of a mesh that has one material.
struct GltfPart {
  std::uint32_t shape = 0;
  GltfSurface surface;
};

class GltfMeshes {
 public:
  /// `variant`: number of the material variant to use.
  GltfMeshes(GltfDocument& document, Accessors& accessors, const GltfNodes& nodes, GltfSurfaces& surfaces,
             std::optional<std::uint32_t> variant, Scene& scene, Diagnostics& diagnostics)
      : document_(document),
        accessors_(accessors),
        nodes_(nodes),
        surfaces_(surfaces),
        variant_(variant),
        scene_(scene),
        sink_(diagnostics) {}

  /// The parts of a node's mesh, in world space if the mesh has a skin. Reports what is wrong. If `weights` is not
  /// null, it replaces the node's own weights of the morph targets.
  std::vector<GltfPart> parts_of(const JsonValue& node, const std::vector<double>* weights = nullptr);
  static bool has_skin(const JsonValue& node) { return node.find("skin") != nullptr; }
  /// The number of primitives that were left out because they are points or lines.
  std::size_t left_out() const { return left_out_; }
  /// The first of them.
  const JsonValue* first_left_out() const { return first_left_out_; }

 private:
  std::vector<GltfPart> read_parts(const JsonValue& mesh, const PrimitivePose& pose, bool shared);
  void add_parts(const JsonValue& primitive, const PrimitivePose& pose, bool shared, std::vector<GltfPart>& parts);
  /// Rows of Scene::shapes, for triangles whose texture coordinates are upright and for those with mirrored ones.
  struct Shapes {
    std::optional<std::uint32_t> upright, mirrored;
  };
  Shapes read_shapes(const JsonValue& primitive, const PrimitiveNeeds& needs, const PrimitivePose& pose);
  std::optional<std::uint32_t> add_shape(TriangleMesh mesh, const JsonValue& primitive);
  std::optional<std::uint32_t> material_of(const JsonValue& primitive) const;
  PrimitivePose pose_of(const JsonValue& node, const JsonValue& mesh);
  std::vector<glm::dmat4> joints_of(std::uint32_t skin, const JsonValue& node);
  void report(const GltfError& error);

  GltfDocument& document_;
  Accessors& accessors_;
  const GltfNodes& nodes_;
  GltfSurfaces& surfaces_;
  std::optional<std::uint32_t> variant_;
  Scene& scene_;
  Diagnostics& sink_;
  std::map<std::string, std::vector<GltfPart>> parts_;  ///< by mesh and weights
  std::map<std::string, Shapes> shapes_;                ///< by accessors, weights and needs
  std::size_t triangles_ = 0, vertices_ = 0;
  std::size_t left_out_ = 0;
  const JsonValue* first_left_out_ = nullptr;
};

}  // namespace etendue
