#include "formats/gltf/gltf_meshes.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/limits.h"

namespace etendue {
namespace {

/// The names and numbers of an object's members, as a key.
std::string signature(const JsonValue* attributes) {
  std::string text;
  if (attributes == nullptr || attributes->object() == nullptr) return text;
  for (const auto& [name, value] : *attributes->object())
    text += fmt::format("{} {} ", name, value.number() == nullptr ? -1.0 : *value.number());
  return text;
}

/// A key that is equal for primitives with the same triangles.
std::string signature(const JsonValue& primitive, const PrimitiveNeeds& needs, const PrimitivePose& pose) {
  std::string text = signature(primitive.find("attributes"));
  for (const char* name : {"indices", "mode"}) {
    const JsonValue* value = primitive.find(name);
    text += fmt::format("{} ", value == nullptr || value->number() == nullptr ? -1.0 : *value->number());
  }
  if (const JsonValue* packed = find_extension(primitive, "KHR_draco_mesh_compression")) text += signature(packed);
  if (std::ranges::any_of(pose.weights, [](double w) { return w != 0.0; })) {
    for (const JsonValue& target : array_of(primitive, "targets")) text += signature(&target) + "/ ";
    text += fmt::format("{}", fmt::join(pose.weights, " "));
  }
  return text + fmt::format("; {} {} {} {} {}", needs.uv_sets, needs.colors, needs.alphas,
                            needs.tangent_uv.value_or(~0u), needs.tangents.value_or(~0u));
}

}  // namespace

void GltfMeshes::report(const GltfError& error) {
  sink_.error(document_.position(*error.where), error.message, error.kind);
}

std::vector<GltfPart> GltfMeshes::parts_of(const JsonValue& node, const std::vector<double>* weights) {
  const auto index = find_index(node, "mesh");
  if (!index) return {};
  const JsonValue& mesh = document_.element("meshes", *index, node);
  PrimitivePose pose = pose_of(node, mesh);
  if (weights != nullptr) pose.weights = *weights;
  if (!pose.joints.empty()) return read_parts(mesh, pose, false);
  const std::string key = fmt::format("{} {}", *index, fmt::join(pose.weights, " "));
  const auto known = parts_.find(key);
  return known != parts_.end() ? known->second : parts_[key] = read_parts(mesh, pose, true);
}

std::vector<GltfPart> GltfMeshes::read_parts(const JsonValue& mesh, const PrimitivePose& pose, bool shared) {
  std::vector<GltfPart> parts;
  for (const JsonValue& primitive : array_of(mesh, "primitives")) {
    try {
      if (primitive.object() == nullptr)
        throw GltfError{&primitive, fmt::format("a primitive is {}", primitive.kind())};
      if (has_triangles(primitive)) {
        add_parts(primitive, pose, shared, parts);
      } else {
        if (left_out_++ == 0) first_left_out_ = &primitive;
      }
    } catch (const GltfError& error) {
      report(error);
    }
  }
  return parts;
}

void GltfMeshes::add_parts(const JsonValue& primitive, const PrimitivePose& pose, bool shared,
                           std::vector<GltfPart>& parts) {
  const std::optional<std::uint32_t> material = material_of(primitive);
  const PrimitiveContent content = primitive_content(document_, accessors_, primitive);
  const PrimitiveNeeds needs = surfaces_.needs(material, content, primitive);
  Shapes shapes;
  if (shared) {
    const std::string key = signature(primitive, needs, pose);
    const auto known = shapes_.find(key);
    shapes = known != shapes_.end() ? known->second : shapes_[key] = read_shapes(primitive, needs, pose);
  } else {
    shapes = read_shapes(primitive, needs, pose);
  }
  if (shapes.upright) parts.push_back({*shapes.upright, surfaces_.surface(material, content, false, primitive)});
  if (shapes.mirrored) parts.push_back({*shapes.mirrored, surfaces_.surface(material, content, true, primitive)});
}

GltfMeshes::Shapes GltfMeshes::read_shapes(const JsonValue& primitive, const PrimitiveNeeds& needs,
                                           const PrimitivePose& pose) {
  PrimitiveMeshes meshes = read_primitive(document_, accessors_, primitive, needs, pose, sink_);
  Shapes shapes;
  shapes.upright = add_shape(std::move(meshes.upright), primitive);
  shapes.mirrored = add_shape(std::move(meshes.mirrored), primitive);
  return shapes;
}

std::optional<std::uint32_t> GltfMeshes::add_shape(TriangleMesh mesh, const JsonValue& primitive) {
  if (mesh.triangles.empty()) return std::nullopt;
  triangles_ += mesh.triangles.size();
  vertices_ += mesh.positions.size();
  if (triangles_ > kMaxTriangles || vertices_ > kMaxVertices)
    throw GltfError{&primitive,
                    fmt::format("up to here the meshes have {} triangles and {} vertices; at most {} and {} "
                                "are supported: use coarser meshes",
                                triangles_, vertices_, kMaxTriangles, kMaxVertices)};
  scene_.shapes.emplace_back(std::move(mesh));
  return static_cast<std::uint32_t>(scene_.shapes.size() - 1);
}

std::optional<std::uint32_t> GltfMeshes::material_of(const JsonValue& primitive) const {
  const JsonValue* variants = find_extension(primitive, "KHR_materials_variants");
  if (variants != nullptr && variant_) {
    for (const JsonValue& mapping : array_of(*variants, "mappings")) {
      const std::vector<std::uint32_t> listed = indices_of(mapping, "variants");
      if (std::ranges::find(listed, *variant_) != listed.end()) return find_index(mapping, "material");
    }
  }
  return find_index(primitive, "material");
}

PrimitivePose GltfMeshes::pose_of(const JsonValue& node, const JsonValue& mesh) {
  PrimitivePose pose;
  pose.weights = find_numbers(node, "weights").value_or(find_numbers(mesh, "weights").value_or(std::vector<double>{}));
  if (const auto skin = find_index(node, "skin")) pose.joints = joints_of(*skin, node);
  return pose;
}

std::vector<glm::dmat4> GltfMeshes::joints_of(std::uint32_t index, const JsonValue& node) {
  const JsonValue& skin = document_.element("skins", index, node);
  const std::vector<std::uint32_t> joints = indices_of(skin, "joints");
  if (joints.empty()) throw GltfError{&skin, "the skin has no \"joints\""};
  std::vector<glm::dmat4> result;
  for (const std::uint32_t joint : joints) {
    document_.element("nodes", joint, skin);
    result.push_back(nodes_.world_from_node(joint));
  }
  const auto inverse = find_index(skin, "inverseBindMatrices");
  if (!inverse) return result;
  const FloatTable matrices = accessors_.floats(*inverse, skin, {16});
  if (matrices.rows() < result.size())
    throw GltfError{&skin, fmt::format("the skin has {} joints and {} matrices", result.size(), matrices.rows())};
  for (std::size_t i = 0; i < result.size(); ++i) {
    glm::dmat4 world_from_bound(1.0);
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row)
        world_from_bound[column][row] = static_cast<double>(matrices.row(i)[4 * column + row]);
    }
    result[i] *= world_from_bound;
  }
  return result;
}

}  // namespace etendue
