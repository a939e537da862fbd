#pragma once
/// The node hierarchy of a glTF asset.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/gltf_animation.h"
#include "formats/gltf/gltf_document.h"

namespace etendue {

class GltfNodes {
 public:
  /// Throws GltfError if a node is its own ancestor or has two parents.
  explicit GltfNodes(const GltfDocument& document, GltfPose pose = {});

  std::size_t size() const { return world_from_node_.size(); }
  const JsonValue& json(std::uint32_t node) const;
  /// The weights of the morph targets if an animation sets them, otherwise null.
  const std::vector<double>* weights(std::uint32_t node) const;
  const glm::dmat4& world_from_node(std::uint32_t node) const { return world_from_node_[node]; }
  /// The node's name, or its number if it has none.
  std::string name(std::uint32_t node) const;
  /// The nodes that a scene shows, parents before their children. Invisible nodes are left out together with everything
  /// below them. Throws GltfError.
  std::vector<std::uint32_t> of_scene(const JsonValue& scene) const;
  /// The same for all nodes of the document.
  std::vector<std::uint32_t> of_all() const;

 private:
  enum class Hidden { shown, left_out };

  /// Lists each node once, even if it can be reached from several roots.
  std::vector<std::uint32_t> below(const std::vector<std::uint32_t>& roots, Hidden hidden) const;

  glm::dmat4 local_transform(std::uint32_t node) const;

  const GltfDocument& document_;
  GltfPose pose_;
  std::vector<std::vector<std::uint32_t>> children_;
  std::vector<std::uint32_t> roots_;
  std::vector<glm::dmat4> world_from_node_;
};

/// T R S of a node or of an instance. `rotation` is (x, y, z, w) and may have any length except 0.
glm::dmat4 gltf_transform(const glm::dvec3& translation, const glm::dvec4& rotation, const glm::dvec3& scale);

}  // namespace etendue
