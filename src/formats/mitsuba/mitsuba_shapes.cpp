#include "formats/mitsuba/mitsuba_shapes.h"

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/text.h"
#include "formats/dialect/mesh_needs.h"
#include "formats/mesh/builtin_meshes.h"
#include "formats/mesh/mesh_content.h"
#include "scene/limits.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

/// After this many errors, no more meshes are opened.
constexpr std::size_t kMaxErrorsBeforeMeshes = 100;
/// Limit on the bytes of all mesh files together.
constexpr std::uintmax_t kMaxMeshBytes = std::uintmax_t{1} << 34;
/// Limit on the shapes that instances of groups show.
constexpr std::size_t kMaxInstances = std::size_t{1} << 20;

/// In Mitsuba, v = 0 is at the first row of a picture.
void turn_over(TriangleMesh& mesh) {
  for (std::vector<glm::vec2>& set : mesh.uv_sets) {
    for (glm::vec2& uv : set) uv.y = 1.0f - uv.y;
  }
}

bool is_round(const Shape& shape) {
  return std::holds_alternative<Sphere>(shape) || std::holds_alternative<Cylinder>(shape);
}

/// Spheres and cylinders cannot be sheared.
RotationAxes axes_for(std::string_view type) {
  return type == "sphere" || type == "cylinder" ? RotationAxes::unit : RotationAxes::as_given;
}

}  // namespace

void MitsubaShapes::add(const XmlElement& element) {
  if (too_much_) return;
  if (++visited_ > kMaxInstances) return report_too_many(context_.document.position(element));
  const auto object = MitsubaObject::read(element, context_, "left out");
  if (!object || object->type() == "shapegroup") return;
  if (object->type() == "merge") return add_all(*object);
  if (object->type() == "instance") return add_group_instance(*object);
  if (std::optional<Instance> instance = read(*object)) add(std::move(*instance));
}

/// Adds the parts of a `merge`. The depth is limited, because references may be circular.
void MitsubaShapes::add_all(const MitsubaObject& object) {
  constexpr int kMaxMerges = 8;
  if (merges_ == kMaxMerges)
    return context_.sink.error(object.position(), fmt::format("merged shapes are nested {} deep", merges_));
  ++merges_;
  for (const XmlElement* part : object.children("shape")) add(*part);
  --merges_;
}

void MitsubaShapes::add(Instance instance) {
  if (scene_.instances.size() < kMaxInstances) return scene_.instances.push_back(std::move(instance));
  report_too_many(instance.position);
}

void MitsubaShapes::report_too_many(const SourcePosition& position) {
  if (std::exchange(too_much_, true)) return;
  context_.sink.error(position, fmt::format("with this shape the scene shows more than {}, those of groups counted at "
                                            "each place; merge meshes",
                                            kMaxInstances));
}

void MitsubaShapes::add_group_instance(const MitsubaObject& object) {
  if (object.children("shape").empty()) return;  // reported
  const XmlElement& shown = *object.children("shape").front();
  const XmlAttribute* type = shown.find("type");
  if (type == nullptr || type->value != "shapegroup")
    return context_.sink.error(object.position(), "an instance shows a <shape type=\"shapegroup\">; refer to one");
  const glm::dmat4 placement = object.matrix("to_world");
  std::optional<glm::dmat4> of_round_shapes;  // read only where needed: it warns
  for (const Instance& part : group(shown)) {
    if (too_much_) return;
    Instance instance = part;
    const bool round = is_round(scene_.shapes[part.shape]);
    if (round && !of_round_shapes) of_round_shapes = object.matrix("to_world", RotationAxes::unit);
    instance.world_from_object =
        (round ? *of_round_shapes : placement) * part.world_from_object + glm::dmat4(0.0);  // no negative zeros
    add(std::move(instance));
  }
}

const std::vector<Instance>& MitsubaShapes::group(const XmlElement& element) {
  const auto [found, is_new] = groups_.try_emplace(&element);
  if (!is_new) return found->second;
  const auto object = MitsubaObject::read(element, context_, "left out");
  std::vector<Instance> parts;
  for (const XmlElement* child : object ? object->children("shape") : std::vector<const XmlElement*>{}) {
    const auto shape = MitsubaObject::read(*child, context_, "left out");
    if (!shape) continue;
    if (shape->type() == "shapegroup" || shape->type() == "instance") {
      context_.sink.error(shape->position(), "a group of shapes cannot hold groups or instances");
      continue;
    }
    if (!shape->children("emitter").empty())
      context_.sink.error(shape->position(), "shapes in groups cannot emit; place the lamp in the scene itself");
    if (auto part = read(*shape)) parts.push_back(std::move(*part));
  }
  return groups_[&element] = std::move(parts);
}

std::optional<Instance> MitsubaShapes::read(const MitsubaObject& object) {
  Instance instance;
  instance.emitter = read_emitter(object);
  const std::vector<const XmlElement*> bsdfs = object.children("bsdf");
  instance.material = bsdfs.empty() ? materials_.default_row(instance.emitter.has_value(), object.position())
                                    : materials_.row_of(*bsdfs.front());
  instance.name = object.type();
  instance.position = object.position();
  instance.world_from_object = object.matrix("to_world", axes_for(object.type()));
  const MeshContent content = content_for(instance.material, scene_.emitter_of(instance), scene_, context_.shows_uv);
  const std::optional<Geometry> geometry = read_geometry(object, content, instance);
  if (!geometry) return std::nullopt;
  instance.shape = geometry->shape;
  const bool mirrored = glm::determinant(glm::dmat3(instance.world_from_object)) < 0.0;
  instance.flip_normals = object.boolean("flip_normals") != (mirrored && geometry->normals_by_winding);
  return instance;
}

std::optional<MitsubaShapes::Geometry> MitsubaShapes::read_geometry(const MitsubaObject& object,
                                                                    const MeshContent& content, Instance& instance) {
  const std::string_view type = object.type();
  const MeshFormat* format = find_mesh_format(type);
  if (format != nullptr || type == "serialized") return read_mesh(object, format, content, instance.name);
  if (type == "sphere") return add_shape(Sphere{object.triple("center"), object.real("radius")}, true);
  if (type == "cylinder") return read_cylinder(object, instance);
  std::optional<Geometry>& known = type == "rectangle" ? rectangle_ : type == "cube" ? cube_ : disk_;
  if (known) return known;
  if (type == "disk") return known = add_shape(Disk{});
  if (type != "rectangle" && type != "cube") throw std::logic_error(fmt::format("the reader has no shape {}", type));
  TriangleMesh mesh = type == "rectangle" ? make_rectangle() : make_cube();
  turn_over(mesh);
  return known = add_shape(std::move(mesh));  // Mitsuba's have normals, which mirror with them
}

std::optional<MitsubaShapes::Geometry> MitsubaShapes::read_cylinder(const MitsubaObject& object, Instance& instance) {
  const glm::dvec3 p0 = object.triple("p0"), p1 = object.triple("p1");
  const double height = glm::distance(p0, p1);
  if (!(height > 0.0)) {
    context_.sink.error(object.position_of("p1"), "p0 and p1 of the cylinder are the same point; move one of them");
    return std::nullopt;
  }
  // Object space: z is along the axis; x, where angles begin, and y follow from it as in [Duff2017].
  const glm::dvec3 n = (p1 - p0) / height;
  const double sign = n.z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + n.z), b = n.x * n.y * a;
  const glm::dmat3 axes = {{1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  const glm::dmat3 m = glm::dmat3(instance.world_from_object) * axes;
  const double x = glm::length(m[0]), y = glm::length(m[1]), z = glm::length(m[2]);
  constexpr double kTolerance = 1e-5;
  const bool round = std::abs(x - y) <= kTolerance * x && std::abs(glm::dot(m[0], m[1])) <= kTolerance * x * y;
  const bool straight =
      std::abs(glm::dot(m[0], m[2])) <= kTolerance * x * z && std::abs(glm::dot(m[1], m[2])) <= kTolerance * y * z;
  if (!round || !straight || !(x > 0.0) || !(z > 0.0)) {
    context_.missing.add("to_world of a cylinder that leaves it no cylinder", object.position_of("to_world"),
                         "round, as wide as along its x");
  }
  const glm::dvec3 along = glm::normalize(m[2]);
  const glm::dvec3 right = glm::normalize(m[0] - glm::dot(m[0], along) * along);
  const double side = glm::determinant(m) < 0.0 ? -1.0 : 1.0;
  const glm::dvec3 base(instance.world_from_object * glm::dvec4(p0, 1.0));
  instance.world_from_object = {glm::dvec4(right, 0.0), glm::dvec4(side * glm::cross(along, right), 0.0),
                                glm::dvec4(along, 0.0), glm::dvec4(base, 1.0)};
  return add_shape(Cylinder{glm::dvec3(0.0), glm::dvec3(0.0, 0.0, height * z), object.real("radius") * x});
}

MitsubaShapes::Geometry MitsubaShapes::add_shape(Shape shape, bool normals_by_winding) {
  scene_.shapes.push_back(std::move(shape));
  return {static_cast<std::uint32_t>(scene_.shapes.size() - 1), normals_by_winding};
}

std::optional<MitsubaShapes::Geometry> MitsubaShapes::read_mesh(const MitsubaObject& object, const MeshFormat* format,
                                                                const MeshContent& content, std::string& name) {
  if (!object.given("filename")) return std::nullopt;
  const SourcePosition position = object.position_of("filename");
  MeshKey key{.path = context_.document.resolve(object.text("filename")),
              .index = 0,
              .face_normals = object.boolean("face_normals"),
              .flip_tex_coords = false,
              .uv = content.uv,
              .textured = content.textured,
              .colors = content.colors,
              .attribute = content.attribute};
  if (content.attributes > 1) context_.missing.add("several attributes of one mesh", position, "one of them");
  if (format == nullptr) key.index = object.integer("shape_index");
  if (format != nullptr) key.flip_tex_coords = object.boolean("flip_tex_coords");
  name = fs::path(key.path).filename().string();
  if (too_much_ || context_.sink.error_count() >= kMaxErrorsBeforeMeshes) return std::nullopt;
  const auto [known, is_new] = meshes_.try_emplace(key);
  if (!is_new) return known->second;
  std::optional<TriangleMesh> mesh = load(format, key, position);
  if (!mesh) return std::nullopt;
  if (mesh->triangles.empty()) {
    context_.sink.warning(position, fmt::format("the mesh {} has no faces; it is left out", text::quoted(name)));
    return std::nullopt;
  }
  // Meshes without normals are smooth, unless the scene asks for flat triangles.
  if (key.face_normals) mesh->normals.clear();
  const bool by_winding = mesh->normals.empty();
  if (!key.face_normals && by_winding) make_smooth_normals(*mesh);
  set_coordinates(key, position, *mesh);
  known->second = add_shape(std::move(*mesh), by_winding);
  return known->second;
}

/// Turns v upward. If coordinates are needed and the file has none, each triangle gets its barycentric ones.
void MitsubaShapes::set_coordinates(const MeshKey& key, const SourcePosition& position, TriangleMesh& mesh) {
  if (!key.uv) return;
  if (!mesh.uv_sets.empty()) {
    if (!key.flip_tex_coords) turn_over(mesh);
    return;
  }
  if (!key.textured) return;
  context_.sink.note(position,
                     "the mesh has no texture coordinates: each triangle shows the texture from (0,0) to (1,0) "
                     "and (0,1)");
  const TriangleMesh joined = std::move(mesh);
  mesh = {};
  mesh.uv_sets.emplace_back();
  mesh.face_colors = joined.face_colors;
  for (const glm::uvec3& t : joined.triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 3; ++k) {
      mesh.positions.push_back(joined.positions[t[k]]);
      if (!joined.normals.empty()) mesh.normals.push_back(joined.normals[t[k]]);
      if (!joined.vertex_colors.empty()) mesh.vertex_colors.push_back(joined.vertex_colors[t[k]]);
      mesh.uv_sets[0].emplace_back(k == 1 ? 1.0f : 0.0f, k == 2 ? 0.0f : 1.0f);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  vertices_ += mesh.positions.size();
  exceeds(vertices_, kMaxVertices, "vertices", position);
}

std::optional<TriangleMesh> MitsubaShapes::open(const MeshFormat* format, MeshKey& key) {
  if (format != nullptr)
    return files_.mesh(*format, key.path, {.uv = key.uv, .colors = key.colors, .attribute = key.attribute},
                       context_.sink);
  std::optional<SerializedMesh> file = files_.serialized(key.path, key.index, context_.sink);
  if (!file) return std::nullopt;
  // Mitsuba 0.6 honours the file's own word for flat triangles, later versions do not.
  const bool old = context_.document.version().starts_with("0.");
  key.face_normals = key.face_normals || (old && file->face_normals);
  return std::move(file->mesh);
}

std::optional<TriangleMesh> MitsubaShapes::load(const MeshFormat* format, MeshKey& key,
                                                const SourcePosition& position) {
  std::error_code unknown;
  const std::uintmax_t bytes = fs::file_size(key.path, unknown);
  if (!unknown) mesh_bytes_ += bytes;
  if (exceeds(mesh_bytes_, kMaxMeshBytes, "bytes of mesh files", position)) return std::nullopt;
  std::optional<TriangleMesh> mesh;
  try {
    mesh = open(format, key);
  } catch (const Error& error) {  // the file cannot be opened or read: say which object names it
    context_.sink.error(position, fmt::format("mesh {}", error.what()), error.kind());
  }
  if (!mesh) return std::nullopt;
  triangles_ += mesh->triangles.size();
  vertices_ += mesh->positions.size();
  if (exceeds(triangles_, kMaxTriangles, "triangles", position)) return std::nullopt;
  if (exceeds(vertices_, kMaxVertices, "vertices", position)) return std::nullopt;
  return mesh;
}

bool MitsubaShapes::exceeds(std::uintmax_t sum, std::uintmax_t limit, const char* what,
                            const SourcePosition& position) {
  if (sum <= limit) return false;
  too_much_ = true;
  context_.sink.error(position, fmt::format("with this mesh the scene has {} {}; at most {} are supported: use coarser "
                                            "meshes",
                                            sum, what, limit));
  return true;
}

std::optional<std::uint32_t> MitsubaShapes::read_emitter(const MitsubaObject& object) {
  const std::vector<const XmlElement*> emitters = object.children("emitter");
  if (emitters.empty()) return std::nullopt;
  const auto emitter = MitsubaObject::read(*emitters.front(), context_, "left out");
  if (!emitter) return std::nullopt;
  if (emitter->type() != "area") {
    context_.sink.error(emitter->position(), fmt::format("an emitter {} cannot belong to a shape; its place is the "
                                                         "<scene>",
                                                         emitter->type()));
    return std::nullopt;
  }
  const ColorParameter radiance = textures_.parameter(emitter->color("radiance", SpectrumUse::emission));
  scene_.emitters.push_back({radiance, emitter->position()});
  return static_cast<std::uint32_t>(scene_.emitters.size() - 1);
}

void MitsubaShapes::finish() {
  if (scene_.instances.empty() && !context_.sink.has_errors())
    context_.sink.warning(scene_.position, "the scene shows no shape");
}

}  // namespace etendue
