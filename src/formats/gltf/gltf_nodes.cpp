#include "formats/gltf/gltf_nodes.h"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

namespace etendue {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// The transform of a node that has a matrix.
glm::dmat4 matrix_of_node(const JsonValue& node) {
  const auto matrix = find_numbers(node, "matrix", 16);
  glm::dmat4 m(1.0);
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) m[column][row] = (*matrix)[static_cast<std::size_t>(4 * column + row)];
  }
  const auto& n = *matrix;
  if (n[3] != 0.0 || n[7] != 0.0 || n[11] != 0.0 || n[15] != 1.0)
    throw GltfError{&node, fmt::format("the last row of the node's matrix is {} {} {} {}; it must be 0 0 0 1", n[3],
                                       n[7], n[11], n[15])};
  return m;
}

bool is_visible(const JsonValue& node) {
  const JsonValue* visibility = find_extension(node, "KHR_node_visibility");
  return visibility == nullptr || bool_or(*visibility, "visible", true);
}

}  // namespace

glm::dmat4 gltf_transform(const glm::dvec3& translation, const glm::dvec4& rotation, const glm::dvec3& scale) {
  const double length = glm::length(rotation);
  const glm::dvec4 q = length > 0.0 ? rotation / length : glm::dvec4(0.0, 0.0, 0.0, 1.0);
  const glm::dmat3 turn = glm::mat3_cast(glm::dquat(q.w, q.x, q.y, q.z));
  return {glm::dvec4(turn[0] * scale.x, 0.0), glm::dvec4(turn[1] * scale.y, 0.0), glm::dvec4(turn[2] * scale.z, 0.0),
          glm::dvec4(translation, 1.0)};
}

glm::dmat4 GltfNodes::local_transform(std::uint32_t node) const {
  const JsonValue& value = json(node);
  if (value.find("matrix") != nullptr) return matrix_of_node(value);
  const glm::dvec3 translation = vec3_or(value, "translation", glm::dvec3(0.0));
  const glm::dvec4 rotation = vec4_or(value, "rotation", glm::dvec4(0.0, 0.0, 0.0, 1.0));
  const glm::dvec3 scale = vec3_or(value, "scale", glm::dvec3(1.0));
  const auto moved = pose_.nodes.find(node);
  if (moved == pose_.nodes.end()) return gltf_transform(translation, rotation, scale);
  const GltfNodePose& pose = moved->second;
  return gltf_transform(pose.translation.value_or(translation), pose.rotation.value_or(rotation),
                        pose.scale.value_or(scale));
}

const std::vector<double>* GltfNodes::weights(std::uint32_t node) const {
  const auto moved = pose_.nodes.find(node);
  return moved == pose_.nodes.end() || !moved->second.weights ? nullptr : &*moved->second.weights;
}

GltfNodes::GltfNodes(const GltfDocument& document, GltfPose pose) : document_(document), pose_(std::move(pose)) {
  const auto count = static_cast<std::uint32_t>(array_of(document.root(), "nodes").size());
  std::vector<std::uint32_t> parent(count, kNone);
  for (std::uint32_t node = 0; node < count; ++node) {
    children_.push_back(indices_of(json(node), "children"));
    for (const std::uint32_t child : children_[node]) {
      document.element("nodes", child, json(node));
      if (parent[child] != kNone)
        throw GltfError{&json(child),
                        fmt::format("node {} is a child of both node {} and node {}", child, parent[child], node)};
      parent[child] = node;
    }
  }
  for (std::uint32_t node = 0; node < count; ++node) {
    if (parent[node] == kNone) roots_.push_back(node);
  }
  // A node that cannot be reached from any root is part of a cycle.
  constexpr double kUnplaced = std::numeric_limits<double>::quiet_NaN();
  world_from_node_.assign(count, glm::dmat4(kUnplaced));
  for (const std::uint32_t node : below(roots_, Hidden::shown)) {
    const glm::dmat4 local = local_transform(node);
    world_from_node_[node] = parent[node] == kNone ? local : world_from_node_[parent[node]] * local;
  }
  for (std::uint32_t node = 0; node < count; ++node) {
    if (std::isnan(world_from_node_[node][0][0]))
      throw GltfError{&json(node), fmt::format("node {} is its own ancestor", node)};
  }
}

const JsonValue& GltfNodes::json(std::uint32_t node) const {
  return document_.element("nodes", node, document_.root());
}

std::string GltfNodes::name(std::uint32_t node) const {
  const std::string name = string_or(json(node), "name", "");
  return name.empty() ? fmt::format("node {}", node) : name;
}

std::vector<std::uint32_t> GltfNodes::of_scene(const JsonValue& scene) const {
  const std::vector<std::uint32_t> roots = indices_of(scene, "nodes");
  for (const std::uint32_t root : roots) document_.element("nodes", root, scene);
  return below(roots, Hidden::left_out);
}

std::vector<std::uint32_t> GltfNodes::of_all() const {
  return below(roots_, Hidden::left_out);
}

std::vector<std::uint32_t> GltfNodes::below(const std::vector<std::uint32_t>& roots, Hidden hidden) const {
  std::vector<std::uint32_t> nodes, waiting(roots.rbegin(), roots.rend());
  std::vector<bool> seen(children_.size(), false);
  while (!waiting.empty()) {
    const std::uint32_t node = waiting.back();
    waiting.pop_back();
    if (seen[node] || (hidden == Hidden::left_out && !is_visible(json(node)))) continue;
    seen[node] = true;
    nodes.push_back(node);
    waiting.insert(waiting.end(), children_[node].rbegin(), children_[node].rend());
  }
  return nodes;
}

}  // namespace etendue
