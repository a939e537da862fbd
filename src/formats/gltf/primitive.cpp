#include "formats/gltf/primitive.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "formats/gltf/draco.h"
#include "formats/mesh/mesh_content.h"
#include "image/vectors.h"
#include "scene/limits.h"

namespace etendue {
namespace {

constexpr std::uint64_t kTriangles = 4, kStrip = 5, kFan = 6;

const JsonValue& attributes_of(const JsonValue& primitive) {
  const JsonValue* attributes = find_object(primitive, "attributes");
  if (attributes == nullptr) throw GltfError{&primitive, "the primitive has no \"attributes\""};
  return *attributes;
}

/// Turns corners into triangles, depending on the mode [glTF 2.0, 3.7.2.1].
std::vector<glm::uvec3> triangles_of(const std::vector<std::uint32_t>& corners, std::uint64_t mode) {
  std::vector<glm::uvec3> triangles;
  if (corners.size() < 3) return triangles;
  const std::size_t count = mode == kTriangles ? corners.size() / 3 : corners.size() - 2;
  triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (mode == kTriangles) {
      triangles.emplace_back(corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]);
    } else if (mode == kStrip) {
      triangles.emplace_back(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
    } else {
      triangles.emplace_back(corners[i + 1], corners[i + 2], corners[0]);
    }
  }
  return triangles;
}

bool is_mirrored(const TriangleMesh& mesh, std::uint32_t uv_set, const glm::uvec3& t) {
  const std::vector<glm::vec2>& uvs = mesh.uv_sets[uv_set];
  const glm::dvec2 a(uvs[t.x]), b = glm::dvec2(uvs[t.y]) - a, c = glm::dvec2(uvs[t.z]) - a;
  return b.x * c.y - b.y * c.x < 0.0;
}

/// Computes tangents of vertices as MikkTSpace does [Mikkelsen2008]: the directions in which u grows on the triangles
/// of a vertex, projected into the plane of its normal and averaged with the triangles' angles as weights. A vertex
/// that has triangles with mirrored coordinates and others without is split in two.
class TangentMaker {
 public:
  TangentMaker(TriangleMesh& mesh, std::uint32_t uv_set) : mesh_(mesh), uv_set_(uv_set) {}

  void make() {
    split();
    mesh_.tangents.assign(mesh_.positions.size(), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
    std::vector<glm::dvec3> sums(mesh_.positions.size(), glm::dvec3(0.0));
    for (const glm::uvec3& t : mesh_.triangles) {
      const glm::dvec3 along = toward_u(t);
      const bool mirrored = is_mirrored(mesh_, uv_set_, t);
      for (int k = 0; k < 3; ++k) {
        const glm::dvec3 here = flat(along, t[k]);
        if (mirrored) mesh_.tangents[t[k]].w = -1.0f;
        if (here != glm::dvec3(0.0)) sums[t[k]] += angle(t, k) * glm::normalize(here);
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double length = glm::length(sums[i]);
      if (length > 0.0) mesh_.tangents[i] = glm::vec4(glm::vec3(sums[i] / length), mesh_.tangents[i].w);
    }
  }

 private:
  /// Gives mirrored triangles their own copies of vertices that they share with others.
  void split() {
    std::vector<bool> upright(mesh_.positions.size(), false);
    std::vector<std::uint32_t> copies(mesh_.positions.size(), 0);  // 0: no copy
    for (const glm::uvec3& t : mesh_.triangles) {
      if (!is_mirrored(mesh_, uv_set_, t)) upright[t.x] = upright[t.y] = upright[t.z] = true;
    }
    for (glm::uvec3& t : mesh_.triangles) {
      if (!is_mirrored(mesh_, uv_set_, t)) continue;
      const glm::uvec3 old = t;
      for (int k = 0; k < 3; ++k) {
        if (!upright[old[k]]) continue;
        if (copies[old[k]] == 0) copies[old[k]] = copy(old[k]);
        t[k] = copies[old[k]];
      }
    }
  }

  std::uint32_t copy(std::uint32_t vertex) {
    const auto append = [&](auto& list) {
      if (list.empty()) return;
      const auto of_vertex = list[vertex];
      list.push_back(of_vertex);
    };
    append(mesh_.positions);
    append(mesh_.normals);
    for (std::vector<glm::vec2>& uvs : mesh_.uv_sets) append(uvs);
    append(mesh_.vertex_colors);
    append(mesh_.vertex_alphas);
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
  }

  /// The direction in which u grows; 0 if the triangle has no area in uv.
  glm::dvec3 toward_u(const glm::uvec3& t) const {
    const std::vector<glm::vec2>& uvs = mesh_.uv_sets[uv_set_];
    const glm::dvec2 origin(uvs[t.x]), b = glm::dvec2(uvs[t.y]) - origin, c = glm::dvec2(uvs[t.z]) - origin;
    const double det = b.x * c.y - b.y * c.x;
    if (det == 0.0) return glm::dvec3(0.0);
    const glm::dvec3 along =
        c.y * (mesh_.positions[t.y] - mesh_.positions[t.x]) - b.y * (mesh_.positions[t.z] - mesh_.positions[t.x]);
    const double length = glm::length(along);
    return length > 0.0 && std::isfinite(length) ? along * ((det < 0.0 ? -1.0 : 1.0) / length) : glm::dvec3(0.0);
  }

  /// A direction projected into the plane of the vertex's normal.
  glm::dvec3 flat(const glm::dvec3& v, std::uint32_t vertex) const {
    if (mesh_.normals.empty()) return v;
    const glm::dvec3& n = mesh_.normals[vertex];
    return v - n * glm::dot(n, v);
  }

  double angle(const glm::uvec3& t, int k) const {
    const glm::dvec3& p = mesh_.positions[t[k]];
    const glm::dvec3 a = flat(mesh_.positions[t[(k + 1) % 3]] - p, t[k]);
    const glm::dvec3 b = flat(mesh_.positions[t[(k + 2) % 3]] - p, t[k]);
    const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
    return std::isfinite(angle) ? angle : 0.0;
  }

  TriangleMesh& mesh_;
  std::uint32_t uv_set_;
};

class PrimitiveReader {
 public:
  PrimitiveReader(GltfDocument& document, Accessors& accessors, const JsonValue& primitive, const PrimitiveNeeds& needs,
                  const PrimitivePose& pose, Diagnostics& diagnostics)
      : document_(document),
        accessors_(accessors),
        primitive_(primitive),
        attributes_(attributes_of(primitive)),
        needs_(needs),
        pose_(pose),
        sink_(diagnostics) {
    const JsonValue* compression = find_extension(primitive, "KHR_draco_mesh_compression");
    if (compression == nullptr) return;
    const auto view = find_index(*compression, "bufferView");
    if (!view) throw GltfError{compression, "the compressed mesh has no \"bufferView\""};
    const std::shared_ptr<const ByteStore> bytes = accessors_.view(*view, *compression);
    packed_ = decode_draco(*compression, bytes->read(0, bytes->size()));
  }

  PrimitiveMeshes read() {
    read_positions();
    read_normals();
    read_coordinates();
    read_colors();
    read_tangents();
    morph();
    bend_by_skin();
    read_triangles();
    finish_normals();
    if (needs_.tangents && mesh_.tangents.empty()) TangentMaker(mesh_, *needs_.tangents).make();
    narrow_vectors(mesh_);
    if (!needs_.tangent_uv) return {std::move(mesh_), {}};
    return split();
  }

 private:
  bool has(const std::string& name) const {
    return (packed_ && packed_->attributes.contains(name)) || attributes_.find(name) != nullptr;
  }

  /// Reads an attribute; it must have as many rows as the positions.
  FloatTable attribute(const std::string& name, std::initializer_list<std::uint32_t> components) {
    FloatTable table = packed_attribute_or_accessor(name, components);
    if (!mesh_.positions.empty() && table.rows() != mesh_.positions.size())
      throw GltfError{&attributes_,
                      fmt::format("{} has {} rows, POSITION has {}", name, table.rows(), mesh_.positions.size())};
    return table;
  }

  FloatTable packed_attribute_or_accessor(const std::string& name, std::initializer_list<std::uint32_t> components) {
    if (!packed_ || !packed_->attributes.contains(name))
      return accessors_.floats(*find_index(attributes_, name), attributes_, components);
    FloatTable table = std::move(packed_->attributes.at(name));
    if (std::ranges::find(components, table.components) == components.end())
      throw GltfError{&attributes_, fmt::format("the compressed {} has {} numbers a row", name, table.components)};
    return table;
  }

  void warn_of(std::size_t some, std::size_t all, const char* what) {
    if (some > 0) sink_.warning(document_.position(primitive_), fmt::format("{} of {} {}", some, all, what));
  }

  static std::vector<glm::vec3> vectors(const FloatTable& table) {
    std::vector<glm::vec3> result(table.rows());
    for (std::size_t i = 0; i < result.size(); ++i) {
      const float* row = table.row(i);
      result[i] = {row[0], row[1], row[2]};
    }
    return result;
  }

  void read_positions() {
    if (!has("POSITION")) throw GltfError{&attributes_, "the primitive has no POSITION"};
    mesh_.positions = VectorList(vectors(attribute("POSITION", {3})));
    if (mesh_.positions.size() > kMaxVertices)
      throw GltfError{&attributes_, fmt::format("the primitive has {} vertices; at most {} are supported",
                                                mesh_.positions.size(), kMaxVertices)};
  }

  void read_normals() {
    if (!has("NORMAL")) return;
    std::vector<glm::vec3> normals = vectors(attribute("NORMAL", {3}));
    if (!is_deformed()) {  // of unit length at once, as precise as the file's
      for (glm::vec3& n : normals) n = glm::vec3(unit_or_same(n));
    }
    mesh_.normals = VectorList(std::move(normals));
  }

  void read_coordinates() {
    for (std::uint32_t set = 0; set < needs_.uv_sets; ++set) {
      const FloatTable table = attribute(fmt::format("TEXCOORD_{}", set), {2});
      std::vector<glm::vec2>& uvs = mesh_.uv_sets.emplace_back(table.rows());
      std::size_t bad = 0;
      for (std::size_t i = 0; i < uvs.size(); ++i) {
        const float u = table.row(i)[0], v = table.row(i)[1];
        const bool good = std::isfinite(u) && std::isfinite(v);
        bad += good ? 0 : 1;
        uvs[i] = good ? glm::vec2(u, 1.0f - v) : glm::vec2(0.0f);
      }
      warn_of(bad, uvs.size(), "texture coordinates are not finite; 0 is used");
    }
  }

  void read_colors() {
    if (!needs_.colors) return;
    const FloatTable table = attribute("COLOR_0", {3, 4});
    std::size_t bad = 0;
    const auto share = [&](float value) {
      if (value >= 0.0f && value <= 1.0f) return value;
      ++bad;
      return value > 0.0f ? 1.0f : 0.0f;  // 0 for NaN, too
    };
    mesh_.vertex_colors.resize(table.rows());
    for (std::size_t i = 0; i < table.rows(); ++i) {
      for (int c = 0; c < 3; ++c) mesh_.vertex_colors[i][c] = share(table.row(i)[c]);
    }
    if (needs_.alphas && table.components == 4) {
      mesh_.vertex_alphas.resize(table.rows());
      for (std::size_t i = 0; i < table.rows(); ++i) mesh_.vertex_alphas[i] = share(table.row(i)[3]);
    }
    warn_of(bad, table.rows() * table.components,
            "numbers of vertex colours are not between 0 and 1; the nearest of these is used");
  }

  /// Takes the tangents of the file, unless some of them are unusable.
  void read_tangents() {
    if (!needs_.tangents || !has("TANGENT")) return;
    const FloatTable table = attribute("TANGENT", {4});
    std::size_t bad = 0;
    mesh_.tangents.resize(table.rows());
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const float* row = table.row(i);
      const glm::vec4 t(row[0], row[1], row[2], row[3] < 0.0f ? -1.0f : 1.0f);
      const float length = glm::length(glm::vec3(t));
      const bool good = length > 0.0f && std::isfinite(length) && row[3] != 0.0f && std::isfinite(row[3]);
      bad += good ? 0 : 1;
      mesh_.tangents[i] = good ? t : glm::vec4(0.0f, 0.0f, 0.0f, 1.0f);
    }
    if (bad == 0) return;
    sink_.warning(
        document_.position(primitive_),
        fmt::format(
            "{} of {} tangents have no direction or no side; the normal texture uses the texture coordinates instead",
            bad, table.rows()));
    mesh_.tangents.clear();
  }

  template <typename Vector>
  void add_target(const JsonValue& target, const std::string& name, double weight, std::vector<Vector>& to) {
    const auto index = find_index(target, name);
    if (!index || to.empty()) return;
    const FloatTable offsets = accessors_.floats(*index, target, {3});
    if (offsets.rows() != to.size())
      throw GltfError{&target,
                      fmt::format("{} of the target has {} rows, the primitive {}", name, offsets.rows(), to.size())};
    for (std::size_t i = 0; i < to.size(); ++i) {
      const float* row = offsets.row(i);
      for (int c = 0; c < 3; ++c)
        to[i][c] = static_cast<typename Vector::value_type>(static_cast<double>(to[i][c]) +
                                                            weight * static_cast<double>(row[c]));
    }
  }

  void morph() {
    const JsonValue::Array& targets = array_of(primitive_, "targets");
    for (std::size_t i = 0; i < std::min(targets.size(), pose_.weights.size()); ++i) {
      if (pose_.weights[i] == 0.0) continue;
      add_target(targets[i], "POSITION", pose_.weights[i], mesh_.positions.edit());
      add_target(targets[i], "NORMAL", pose_.weights[i], mesh_.normals.edit());
      add_target(targets[i], "TANGENT", pose_.weights[i], mesh_.tangents);
    }
  }

  void bend_by_skin() {
    if (pose_.joints.empty() || !has("JOINTS_0")) return;
    std::vector<glm::dmat4> blends(mesh_.positions.size(), glm::dmat4(0.0));
    for (int set = 0; has(fmt::format("JOINTS_{}", set)) && has(fmt::format("WEIGHTS_{}", set)); ++set)
      add_joints(set, blends);
    std::size_t still = 0;
    std::vector<glm::dvec3>&positions = mesh_.positions.edit(), &normals = mesh_.normals.edit();
    for (std::size_t i = 0; i < blends.size(); ++i) {
      const double sum = blends[i][3][3];
      if (!(sum > 0.0)) ++still;
      const glm::dmat4 blend = sum > 0.0 ? blends[i] / sum : glm::dmat4(1.0);
      positions[i] = glm::dvec3(blend * glm::dvec4(positions[i], 1.0));
      const glm::dmat3 linear(blend);
      if (!mesh_.tangents.empty()) {
        glm::vec4& t = mesh_.tangents[i];
        t = glm::vec4(glm::vec3(linear * glm::dvec3(t)), t.w);
      }
      if (!normals.empty() && glm::determinant(linear) != 0.0)
        normals[i] = glm::transpose(glm::inverse(linear)) * normals[i];
    }
    warn_of(still, blends.size(), "vertices have no weight above 0; the skin does not move them");
  }

  void add_joints(int set, std::vector<glm::dmat4>& blends) {
    const FloatTable joints = attribute(fmt::format("JOINTS_{}", set), {4});
    const FloatTable weights = attribute(fmt::format("WEIGHTS_{}", set), {4});
    for (std::size_t i = 0; i < blends.size(); ++i) {
      for (int k = 0; k < 4; ++k) {
        const double weight = weights.row(i)[k], joint = joints.row(i)[k];
        if (!(weight > 0.0)) continue;
        if (!(joint >= 0.0 && joint < static_cast<double>(pose_.joints.size())))
          throw GltfError{&attributes_,
                          fmt::format("a vertex refers to joint {}; the skin has {}", joint, pose_.joints.size())};
        blends[i] += weight * pose_.joints[static_cast<std::size_t>(joint)];
      }
    }
  }

  std::vector<std::uint32_t> corners(const std::optional<std::uint32_t>& index) {
    if (packed_) return std::move(packed_->indices);
    if (index) return accessors_.integers(*index, primitive_);
    std::vector<std::uint32_t> all(mesh_.positions.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
    return all;
  }

  void read_triangles() {
    // Draco decodes to triangles, whatever the primitive was before.
    const std::uint64_t mode = packed_ ? kTriangles : count_or(primitive_, "mode", kTriangles);
    const auto index = find_index(primitive_, "indices");
    // Without a copy where possible: a mesh may have millions.
    mesh_.triangles = mode == kTriangles && index && !packed_ ? accessors_.triangles(*index, primitive_)
                                                              : triangles_of(corners(index), mode);
    if (mesh_.triangles.size() > kMaxTriangles)
      throw GltfError{&primitive_, fmt::format("the primitive has {} triangles; at most {} are supported",
                                               mesh_.triangles.size(), kMaxTriangles)};
    leave_out("refer to vertices that do not exist", [&](const glm::uvec3& t) {
      return std::max({t.x, t.y, t.z}) >= mesh_.positions.size();
    });
    leave_out("have a vertex that is not finite", [&](const glm::uvec3& t) {
      return !is_finite(mesh_.positions[t.x]) || !is_finite(mesh_.positions[t.y]) || !is_finite(mesh_.positions[t.z]);
    });
    drop_unused_vertices(mesh_);
  }

  template <typename F>
  void leave_out(const char* why, const F& is_bad) {
    const std::size_t before = mesh_.triangles.size();
    const std::size_t count = std::erase_if(mesh_.triangles, is_bad);
    if (count > 0)
      sink_.warning(document_.position(primitive_),
                    fmt::format("{} of {} triangles {}; they are left out", count, before, why));
  }

  bool is_deformed() const {
    return !pose_.joints.empty() || std::ranges::any_of(pose_.weights, [](double w) { return w != 0.0; });
  }

  static bool has_direction(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0.0 && std::isfinite(length);
  }
  static glm::dvec3 unit_or_same(const glm::dvec3& v) { return has_direction(v) ? v / glm::length(v) : v; }

  void finish_normals() {
    const auto bad = mesh_.normals.size() -
                     static_cast<std::size_t>(std::ranges::count_if(mesh_.normals, &PrimitiveReader::has_direction));
    if (bad > 0) {
      sink_.warning(document_.position(primitive_),
                    fmt::format("{} of {} normals have no direction; the primitive is shown with flat faces", bad,
                                mesh_.normals.size()));
      mesh_.normals.clear();
    } else if (is_deformed()) {
      for (glm::dvec3& n : mesh_.normals.edit()) n = unit_or_same(n);
    }
  }

  /// Separates the triangles with mirrored texture coordinates, whose bitangent is −(n × t).
  PrimitiveMeshes split() {
    const std::uint32_t set = *needs_.tangent_uv;
    if (std::ranges::none_of(mesh_.triangles, [&](const glm::uvec3& t) { return is_mirrored(mesh_, set, t); }))
      return {std::move(mesh_), {}};
    PrimitiveMeshes parts{mesh_, std::move(mesh_)};
    std::erase_if(parts.upright.triangles, [&](const glm::uvec3& t) { return is_mirrored(parts.upright, set, t); });
    std::erase_if(parts.mirrored.triangles, [&](const glm::uvec3& t) { return !is_mirrored(parts.mirrored, set, t); });
    drop_unused_vertices(parts.upright);
    drop_unused_vertices(parts.mirrored);
    return parts;
  }

  GltfDocument& document_;
  Accessors& accessors_;
  const JsonValue& primitive_;
  const JsonValue& attributes_;
  const PrimitiveNeeds& needs_;
  const PrimitivePose& pose_;
  Diagnostics& sink_;
  std::optional<DracoMesh> packed_;
  TriangleMesh mesh_;
};

}  // namespace

PrimitiveContent primitive_content(const GltfDocument& document, Accessors& accessors, const JsonValue& primitive) {
  const JsonValue& attributes = attributes_of(primitive);
  PrimitiveContent content;
  while (attributes.find(fmt::format("TEXCOORD_{}", content.uv_sets)) != nullptr) ++content.uv_sets;
  const bool packed = find_extension(primitive, "KHR_draco_mesh_compression") != nullptr;
  content.normals = attributes.find("NORMAL") != nullptr;
  const auto color = find_index(attributes, "COLOR_0");
  if (!color) return content;
  const auto is_one = [](float value) { return value == 1.0f; };
  // Many exporters write white for all vertices, which has no effect.
  content.colors = packed || !std::ranges::all_of(accessors.floats(*color, attributes, {3, 4}).numbers, is_one);
  content.colors_have_alpha =
      content.colors && string_or(document.element("accessors", *color, attributes), "type", "") == "VEC4";
  return content;
}

bool has_triangles(const JsonValue& primitive) {
  const std::uint64_t mode = count_or(primitive, "mode", kTriangles);
  if (mode > kFan) throw GltfError{&primitive, fmt::format("the mode {} is unknown; modes are 0 to 6", mode)};
  return mode >= kTriangles;
}

PrimitiveMeshes read_primitive(GltfDocument& document, Accessors& accessors, const JsonValue& primitive,
                               const PrimitiveNeeds& needs, const PrimitivePose& pose, Diagnostics& diagnostics) {
  return PrimitiveReader(document, accessors, primitive, needs, pose, diagnostics).read();
}

}  // namespace etendue
