#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "core/text.h"
#include "formats/gltf/gltf_audit_parts.h"

namespace etendue::gltf_audit {
namespace {

/// Attributes that morph targets cannot move.
bool is_fixed(std::string_view kind) {
  return kind == "JOINTS_" || kind == "WEIGHTS_";
}

class LinkAuditor {
 public:
  LinkAuditor(const JsonValue& root, const GltfComplaint& complain) : root_(root), warn_(complain) {}

  void run() {
    find_parents();
    for (const JsonValue& mesh : list(root_, "meshes")) audit_mesh(mesh);
    const JsonValue::Array& nodes = list(root_, "nodes");
    for (std::size_t node = 0; node < nodes.size(); ++node) audit_node(nodes[node], node);
    for (const JsonValue& skin : list(root_, "skins")) audit_skin(skin);
  }

 private:
  void find_parents() {
    const JsonValue::Array& nodes = list(root_, "nodes");
    parents_.assign(nodes.size(), kNone);
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      for (const JsonValue& child : list(nodes[node], "children")) {
        if (const auto index = node_number(child)) parents_[*index] = node;
      }
    }
  }

  std::optional<std::size_t> node_number(const JsonValue& value) const {
    const double* n = value.number();
    if (n == nullptr || !(*n >= 0.0 && *n < static_cast<double>(parents_.size()))) return std::nullopt;
    return static_cast<std::size_t>(*n);
  }

  /// `node` and all above it.
  std::vector<std::size_t> ancestors(std::size_t node) const {
    std::vector<std::size_t> line;
    // The reader has refused cycles; counting is for documents that it did not get to read.
    for (; node != kNone && line.size() <= parents_.size(); node = parents_[node]) line.push_back(node);
    return line;
  }

  void audit_mesh(const JsonValue& mesh) {
    const JsonValue::Array& primitives = list(mesh, "primitives");
    for (const JsonValue& primitive : primitives) {
      const JsonValue* attributes = primitive.find("attributes");
      if (attributes == nullptr || attributes->object() == nullptr) continue;
      audit_primitive(primitive, *attributes);
      if (list(primitive, "targets").size() != list(primitives.front(), "targets").size())
        warn_(primitive, "the primitives of the mesh have different numbers of morph targets");
      if (has(primitive, "JOINTS_0") != has(primitives.front(), "JOINTS_0"))
        warn_(primitive, "some primitives of the mesh have JOINTS_0 and others do not; a skin moves only the former");
    }
  }

  static bool has(const JsonValue& primitive, std::string_view attribute) {
    const JsonValue* attributes = primitive.find("attributes");
    return attributes != nullptr && attributes->find(attribute) != nullptr;
  }

  void audit_primitive(const JsonValue& primitive, const JsonValue& attributes) {
    const JsonValue* positions = element_of(root_, "accessors", attributes, "POSITION");
    const auto count = positions == nullptr ? std::nullopt : number_in(*positions, "count");
    if (positions != nullptr && (positions->find("min") == nullptr || positions->find("max") == nullptr))
      warn_(*positions, "an accessor of a POSITION has no \"min\" and \"max\", which it must have");
    if (attributes.object()->empty()) warn_(attributes, "\"attributes\" is empty; it must have an element");
    std::set<std::string_view> names;
    for (const auto& [name, value] : *attributes.object()) {
      audit_attribute(attributes, name, value, count);
      names.insert(name);
    }
    if (attributes.find("TANGENT") != nullptr && attributes.find("NORMAL") == nullptr)
      warn_(attributes, "TANGENT comes without NORMAL; it is not used");
    for (const JsonValue& target : list(primitive, "targets")) audit_target(target, names, count);
    audit_indices(primitive, count);
  }

  /// Names with a number that is not written as it must be: "TEXCOORD_01".
  static bool is_numbered_badly(std::string_view name) {
    const std::string_view kind = kind_of_attribute(name);
    if (!kind.ends_with('_')) return false;
    const std::string_view number = name.substr(kind.size());
    const bool digits = !number.empty() && std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
    return !digits || (number.size() > 1 && number.front() == '0');
  }

  void audit_attribute(const JsonValue& attributes, const std::string& name, const JsonValue& value,
                       std::optional<double> rows) {
    if (is_numbered_badly(name))
      warn_(attributes, fmt::format("the attribute {} has no proper number; it is ignored", text::quoted(name)));
    const JsonValue* accessor = element_at(root_, "accessors", value);
    if (accessor == nullptr) return;
    const std::string_view types = types_of_attribute(kind_of_attribute(name));
    const std::string type = string_in(*accessor, "type");
    if (!types.empty() && !type.empty() && types.find(type) == std::string_view::npos)
      warn_(*accessor, fmt::format("{} has the type {}; it must be {}", name, text::quoted(type), types));
    if (number_in(*accessor, "componentType") == kUnsignedInt)
      warn_(*accessor, fmt::format("{} has the component type 5125, which attributes of vertices must not have", name));
    const auto count = number_in(*accessor, "count");
    if (rows && count && *rows != *count)
      warn_(*accessor, fmt::format("{} has {} rows, POSITION has {}", name, *count, *rows));
  }

  void audit_target(const JsonValue& target, const std::set<std::string_view>& attributes, std::optional<double> rows) {
    if (target.object() == nullptr) return;
    for (const auto& [name, value] : *target.object()) {
      const std::string_view kind = kind_of_attribute(name);
      if (is_fixed(kind))
        warn_(target, fmt::format("a morph target has {}, which targets cannot move; it is ignored", name));
      if (!attributes.contains(name))
        warn_(target, fmt::format("a morph target moves {}, which the primitive does not have; it is ignored", name));
      const JsonValue* accessor = element_at(root_, "accessors", value);
      if (accessor == nullptr) {
        warn_(value, fmt::format("{} of a morph target refers to an accessor that does not exist", name));
        continue;
      }
      const auto count = number_in(*accessor, "count");
      if (rows && count && *rows != *count)
        warn_(*accessor, fmt::format("{} of a morph target has {} rows, the primitive has {}", name, *count, *rows));
      // Sides of tangents do not move.
      const std::string_view types = name == "TANGENT" ? "VEC3" : types_of_attribute(kind);
      const std::string type = string_in(*accessor, "type");
      if (!types.empty() && !type.empty() && types.find(type) == std::string_view::npos)
        warn_(*accessor,
              fmt::format("{} of a morph target has the type {}; it must be {}", name, text::quoted(type), types));
    }
  }

  void audit_indices(const JsonValue& primitive, std::optional<double> rows) {
    const JsonValue* accessor = element_of(root_, "accessors", primitive, "indices");
    if (accessor != nullptr && is_true(*accessor, "normalized"))
      warn_(*accessor, "indices are \"normalized\", which they must not be; it is ignored");
    if (const std::string type = accessor == nullptr ? "SCALAR" : string_in(*accessor, "type"); type != "SCALAR")
      warn_(*accessor, fmt::format("indices have the type {}; it must be SCALAR", text::quoted(type)));
    const auto corners = accessor == nullptr ? rows : number_in(*accessor, "count");
    const double mode = number_in(primitive, "mode").value_or(4.0);
    if (!corners || primitive.find("extensions") != nullptr) return;
    const double n = *corners;
    const bool fits = mode == 4.0   ? std::fmod(n, 3.0) == 0.0
                      : mode >= 5.0 ? n >= 3.0
                      : mode == 1.0 ? std::fmod(n, 2.0) == 0.0
                                    : n >= (mode == 0.0 ? 1.0 : 2.0);
    if (!fits)
      warn_(primitive, fmt::format("{} corners are no whole number of primitives of the mode {}; what is left over is "
                                   "left out",
                                   n, mode));
  }

  void audit_node(const JsonValue& node, std::size_t number) {
    const JsonValue* mesh = element_of(root_, "meshes", node, "mesh");
    if (mesh == nullptr && node.find("weights") != nullptr)
      warn_(node, "the node has \"weights\" but no mesh; they move nothing");
    if (mesh == nullptr && node.find("skin") != nullptr)
      warn_(node, "the node has a \"skin\" but no mesh; it moves nothing");
    if (mesh != nullptr && !list(*mesh, "primitives").empty()) audit_skinned_node(node, number, *mesh);
    audit_matrix(node);
  }

  void audit_skinned_node(const JsonValue& node, std::size_t number, const JsonValue& mesh) {
    const bool has_joints = has(list(mesh, "primitives").front(), "JOINTS_0");
    if (node.find("skin") == nullptr) {
      if (has_joints) warn_(node, "the node shows a mesh with JOINTS_0 but has no \"skin\"; the mesh keeps its shape");
      return;
    }
    if (!has_joints) return warn_(node, "the node has a \"skin\", but its mesh has no JOINTS_0; nothing moves");
    const bool moved =
        std::ranges::any_of(std::initializer_list<const char*>{"matrix", "translation", "rotation", "scale"},
                            [&](const char* part) { return node.find(part) != nullptr; });
    if (parents_[number] != kNone)
      warn_(node, "the node of a skinned mesh is not a root; only its joints move it, not its parents");
    if (moved) warn_(node, "the node of a skinned mesh has a transform of its own, which is ignored: joints move it");
    const JsonValue* skin = element_of(root_, "skins", node, "skin");
    if (skin != nullptr) audit_scene_of_joints(node, number, *skin);
  }

  /// A scene that shows a skinned mesh must hold its joints.
  void audit_scene_of_joints(const JsonValue& node, std::size_t number, const JsonValue& skin) {
    const auto shows = [&](const JsonValue& scene, std::size_t what) {
      const std::vector<std::size_t> line = ancestors(what);
      steps_ += line.size() * list(scene, "nodes").size();
      return std::ranges::any_of(list(scene, "nodes"), [&](const JsonValue& root) {
        const auto index = node_number(root);
        return index && std::ranges::find(line, *index) != line.end();
      });
    };
    const JsonValue::Array& joints = list(skin, "joints");
    const auto first = joints.empty() ? std::nullopt : node_number(joints.front());
    for (const JsonValue& scene : list(root_, "scenes")) {
      if (first && steps_ < kMostSteps && shows(scene, number) && !shows(scene, *first))
        warn_(node, "the joints of the node's skin are not in its scene; they move it all the same");
    }
  }

  /// Matrices of nodes must be made of translation, rotation and scale.
  void audit_matrix(const JsonValue& node) {
    const JsonValue::Array& numbers = list(node, "matrix");
    if (numbers.size() != 16) return;
    glm::dmat3 m(0.0);
    for (std::size_t i = 0; i < 12; ++i) {
      if (numbers[i].number() == nullptr) return;
      if (i % 4 < 3) m[static_cast<int>(i / 4)][static_cast<int>(i % 4)] = *numbers[i].number();
    }
    constexpr double kTolerance = 1e-3;
    for (int a = 0; a < 3; ++a) {
      const glm::dvec3 &u = m[a], &v = m[(a + 1) % 3];
      if (std::abs(glm::dot(u, v)) > kTolerance * glm::length(u) * glm::length(v))
        return warn_(node,
                     "the node's \"matrix\" shears; it must be a translation, a rotation and a scale; it is used "
                     "as it is");
    }
  }

  void audit_skin(const JsonValue& skin) {
    const JsonValue::Array& joints = list(skin, "joints");
    if (joints.empty()) return;
    const auto first = node_number(joints.front());
    if (!first) return;
    std::vector<std::size_t> common = ancestors(*first);
    for (const JsonValue& joint : joints) {
      const auto index = node_number(joint);
      if (!index) return;
      const std::vector<std::size_t> line = ancestors(*index);
      if ((steps_ += line.size() * (common.size() + 1)) > kMostSteps) return;
      std::erase_if(common, [&](std::size_t n) { return std::ranges::find(line, n) == line.end(); });
    }
    const JsonValue* named = skin.find("skeleton");
    const auto skeleton = named == nullptr ? std::nullopt : node_number(*named);
    if (common.empty()) {
      warn_(skin, "the joints of the skin have no common root");
    } else if (skeleton && std::ranges::find(common, *skeleton) == common.end()) {
      warn_(*named, fmt::format("\"skeleton\" is node {}, which is not above all joints; it is ignored", *skeleton));
    }
  }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  /// Ancestors are compared one by one, which would take hours for deep trees with very many joints.
  static constexpr std::size_t kMostSteps = std::size_t{1} << 24;
  std::size_t steps_ = 0;
  const JsonValue& root_;
  const GltfComplaint& warn_;
  std::vector<std::size_t> parents_;
};

}  // namespace

void audit_links(const JsonValue& root, const GltfComplaint& complain) {
  LinkAuditor(root, complain).run();
}

}  // namespace etendue::gltf_audit
