#include "formats/mitsuba/mitsuba_shapes.h"

#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/text.h"
#include "formats/mesh/builtin_meshes.h"
#include "formats/mesh/mesh_content.h"
#include "scene/limits.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

/// Errors after which meshes are no longer opened.
constexpr std::size_t kMaxErrorsBeforeMeshes = 100;
/// What materials and emitters use of meshes, beside their surface.
constexpr MeshContent kContent = {.uv = false, .colors = false};
/// Bytes of all mesh files together.
constexpr std::uintmax_t kMaxMeshBytes = std::uintmax_t{1} << 34;
/// Shapes that groups show, each of their places counting.
constexpr std::size_t kMaxInstances = std::size_t{1} << 20;

}  // namespace

void MitsubaShapes::add(const XmlElement& element) {
  const auto object = MitsubaObject::read(element, context_, "left out");
  if (!object || object->type() == "shapegroup") return;
  if (object->type() == "instance") return add_group_instance(*object);
  if (std::optional<Instance> instance = read(*object)) add(std::move(*instance));
}

void MitsubaShapes::add(Instance instance) {
  if (scene_.instances.size() < kMaxInstances) return scene_.instances.push_back(std::move(instance));
  if (std::exchange(too_much_, true)) return;
  context_.sink.error(instance.position, fmt::format("with this shape the scene shows more than {}, those of groups "
                                                     "counted at each place; merge meshes",
                                                     kMaxInstances));
}

void MitsubaShapes::add_group_instance(const MitsubaObject& object) {
  if (object.children("shape").empty()) return;  // reported
  const XmlElement& shown = *object.children("shape").front();
  const XmlAttribute* type = shown.find("type");
  if (type == nullptr || type->value != "shapegroup")
    return context_.sink.error(object.position(), "an instance shows a <shape type=\"shapegroup\">; refer to one");
  const glm::dmat4 placement = object.matrix("to_world");
  for (const Instance& part : group(shown)) {
    if (too_much_) return;
    Instance instance = part;
    instance.world_from_object = placement * part.world_from_object;
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
  const std::optional<std::uint32_t> shape = read_geometry(object, instance.name);
  if (!shape) return std::nullopt;
  instance.shape = *shape;
  instance.world_from_object = object.matrix("to_world");
  instance.flip_normals = object.boolean("flip_normals");
  if (instance.flip_normals && object.type() == "sphere") {
    instance.flip_normals = false;
    context_.missing.add("flip_normals of a sphere", object.position_of("flip_normals"), "not flipped");
  }
  instance.position = object.position();
  return instance;
}

std::optional<std::uint32_t> MitsubaShapes::read_geometry(const MitsubaObject& object, std::string& name) {
  const std::string_view type = object.type();
  const MeshFormat* format = find_mesh_format(type);
  if (format != nullptr || type == "serialized") return read_mesh(object, format, name);
  if (type == "sphere") return add_shape(Sphere{object.triple("center"), object.real("radius")});
  if (type == "rectangle") {
    if (!rectangle_) rectangle_ = add_shape(make_rectangle());
    return rectangle_;
  }
  if (type == "cube") {
    if (!cube_) cube_ = add_shape(make_cube());
    return cube_;
  }
  throw std::logic_error(fmt::format("the reader has no shape {}", type));
}

std::uint32_t MitsubaShapes::add_shape(Shape shape) {
  scene_.shapes.push_back(std::move(shape));
  return static_cast<std::uint32_t>(scene_.shapes.size() - 1);
}

std::optional<std::uint32_t> MitsubaShapes::read_mesh(const MitsubaObject& object, const MeshFormat* format,
                                                      std::string& name) {
  if (!object.given("filename")) return std::nullopt;
  const SourcePosition position = object.position_of("filename");
  MeshKey key{context_.document.resolve(object.text("filename")), 0, object.boolean("face_normals"), false};
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
  // Smooth where the file has no normals, unless the scene wants its triangles flat.
  if (key.face_normals) mesh->normals.clear();
  if (!key.face_normals && mesh->normals.empty()) make_smooth_normals(*mesh);
  known->second = add_shape(std::move(*mesh));
  return known->second;
}

std::optional<TriangleMesh> MitsubaShapes::open(const MeshFormat* format, MeshKey& key) {
  if (format != nullptr) return files_.mesh(*format, key.path, kContent, context_.sink);
  std::optional<SerializedMesh> file = files_.serialized(key.path, key.index, context_.sink);
  if (!file) return std::nullopt;
  key.face_normals = key.face_normals || file->face_normals;
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
  } catch (const Error& error) {  // the file cannot be opened or read: say who asked for it
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
  const glm::dvec3 radiance = materials_.constant(emitter->color("radiance", SpectrumUse::emission));
  scene_.emitters.push_back({radiance, emitter->position()});
  return static_cast<std::uint32_t>(scene_.emitters.size() - 1);
}

void MitsubaShapes::finish() {
  if (scene_.instances.empty() && !context_.sink.has_errors())
    context_.sink.warning(scene_.position, "the scene shows no shape");
}

}  // namespace etendue
