#include "formats/gltf/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/errors.h"
#include "core/long_task.h"
#include "core/text.h"
#include "formats/camera_option.h"
#include "formats/gltf/accessors.h"
#include "formats/gltf/gltf_audit.h"
#include "formats/gltf/gltf_lights.h"
#include "formats/gltf/gltf_meshes.h"
#include "formats/gltf/gltf_nodes.h"
#include "formats/gltf/gltf_surfaces.h"
#include "formats/gltf/gltf_textures.h"
#include "formats/gltf/uri.h"
#include "formats/model/studio.h"
#include "scene/invariants.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

/// A limit, because a few bytes can ask for billions of instances.
constexpr std::size_t kMaxInstances = std::size_t{1} << 22;

/// Extensions that are read or do not affect the picture.
constexpr std::string_view kExtensions[] = {
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_structural_metadata",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
};

class GltfReader {
 public:
  GltfReader(GltfDocument& document, const ReadOptions& options, Diagnostics& diagnostics)
      : document_(document),
        options_(options),
        sink_(diagnostics),
        accessors_(document_),
        textures_(document_, accessors_, scene_, diagnostics, options.approximate),
        surfaces_(document_, textures_, scene_, diagnostics) {
    scene_.name = fs::path(document_.path()).stem().string();
    scene_.file = document_.path();
    scene_.position = {document_.path(), 0, 0};
  }

  /// Returns nothing after an error.
  std::optional<Scene> read() {
    try {
      return read_scene();
    } catch (const GltfError& error) {
      report(error);
      return std::nullopt;
    }
  }

 private:
  std::optional<Scene> read_scene() {
    const std::size_t errors_before = sink_.error_count();
    check_extensions();
    const GltfNodes nodes(document_, read_pose());
    GltfMeshes meshes(document_, accessors_, nodes, surfaces_, chosen_variant(), scene_, sink_);
    set_viewer_sampling(scene_);
    show(nodes, shown_nodes(nodes), meshes);
    if (sink_.error_count() > errors_before) return std::nullopt;
    if (scene_.instances.empty()) {
      audit_gltf(document_, accessors_, !options_.at, sink_);
      sink_.error(scene_.position, "the scene has no triangles; there is nothing to show");
      return std::nullopt;
    }
    choose_camera(nodes);
    add_light();
    say_what_is_left_out(meshes);
    if (sink_.error_count() > errors_before) return std::nullopt;
    audit_gltf(document_, accessors_, !options_.at, sink_);
    return std::move(scene_);
  }

  /// Without a requested time, the nodes keep their own transforms.
  GltfPose read_pose() {
    const JsonValue::Array& animations = array_of(document_.root(), "animations");
    std::optional<std::uint32_t> animation;
    if (!options_.animation.empty()) animation = chosen(options_.animation, names_of(animations), "--animation");
    if (!options_.at) {
      if (animation) throw Error(ErrorKind::usage, "--animation chooses what --at TIME or --frames plays; add one");
      return {};
    }
    if (animations.empty())
      throw Error(ErrorKind::usage,
                  fmt::format("--at: nothing in {} moves; the asset has no animations", document_.path()));
    GltfPose pose = gltf_pose(document_, accessors_, *options_.at, animation, sink_);
    if (*options_.at > pose.end)
      sink_.note(scene_.position,
                 fmt::format("{} s is after the end of the animations, at {} s", *options_.at, pose.end));
    return pose;
  }

  void report(const GltfError& error) { sink_.error(document_.position(*error.where), error.message, error.kind); }

  void check_extensions() {
    const auto known = [](const std::string& name) {
      return std::ranges::find(kExtensions, name) != std::end(kExtensions);
    };
    const std::vector<std::string> required = strings_of(document_.root(), "extensionsRequired");
    for (const std::string& name : required) {
      if (!known(name))
        sink_.error(document_.position(*document_.root().find("extensionsRequired")),
                    fmt::format("the asset requires the extension {}, which is not supported", text::quoted(name)));
    }
    for (const std::string& name : strings_of(document_.root(), "extensionsUsed")) {
      if (!known(name) && std::ranges::find(required, name) == required.end())
        sink_.warning(document_.position(*document_.root().find("extensionsUsed")),
                      fmt::format("the asset uses the extension {}, which is ignored", text::quoted(name)));
    }
  }

  /// The number of the element that `choice` names or whose number it is. Throws Error(usage).
  static std::uint32_t chosen(const std::string& choice, const std::vector<std::string>& names, const char* option) {
    const auto named = std::ranges::find(names, choice);
    if (named != names.end()) return static_cast<std::uint32_t>(named - names.begin());
    std::int64_t number = 0;
    if (text::parse_integer(choice, number) == text::NumberError::none && number >= 0 &&
        number < static_cast<std::int64_t>(names.size()))
      return static_cast<std::uint32_t>(number);
    std::vector<std::string> quoted;
    for (const std::string& name : names) quoted.push_back(text::quoted(name));
    constexpr std::size_t kMostListed = 30;
    if (quoted.size() > kMostListed) quoted.resize(kMostListed);
    throw Error(ErrorKind::usage, fmt::format("{} {}: there is none with this name or number; there {}", option,
                                              text::printable(choice, 100),
                                              quoted.empty() ? "are none" : fmt::format("are {}", text::join(quoted))));
  }

  static std::vector<std::string> names_of(const JsonValue::Array& elements) {
    std::vector<std::string> names;
    for (const JsonValue& element : elements) names.push_back(string_or(element, "name", ""));
    return names;
  }

  std::optional<std::uint32_t> chosen_variant() const {
    if (options_.variant.empty()) return std::nullopt;
    const JsonValue* extension = find_extension(document_.root(), "KHR_materials_variants");
    const JsonValue::Array none;
    return chosen(options_.variant, names_of(extension == nullptr ? none : array_of(*extension, "variants")),
                  "--variant");
  }

  std::vector<std::uint32_t> shown_nodes(const GltfNodes& nodes) {
    const JsonValue::Array& scenes = array_of(document_.root(), "scenes");
    std::optional<std::uint32_t> index = find_index(document_.root(), "scene");
    if (!options_.scene.empty()) {
      index = chosen(options_.scene, names_of(scenes), "--scene");
    } else if (!index && !scenes.empty()) {
      index = 0;
    }
    if (index) {
      if (scenes.size() > 1 && options_.scene.empty())
        sink_.note(scene_.position,
                   fmt::format("scene {} of {} is shown; --scene chooses another", *index, scenes.size()));
      const JsonValue* where = options_.scene.empty() ? document_.root().find("scene") : nullptr;
      return nodes.of_scene(document_.element("scenes", *index, where == nullptr ? document_.root() : *where));
    }
    sink_.warning(scene_.position, "the asset has no scene; all of its nodes are shown");
    return nodes.of_all();
  }

  void show(const GltfNodes& nodes, const std::vector<std::uint32_t>& shown, GltfMeshes& meshes) {
    LongTask task("Reading meshes", shown.size());
    const LampRule rule = lamp_rule(document_.root(), options_.lamps);
    for (const std::uint32_t node : shown) {
      const JsonValue& json = nodes.json(node);
      try {
        show_mesh(nodes, node, meshes.parts_of(json, nodes.weights(node)));
        if (json.find("camera") != nullptr) cameras_.push_back(node);
        if (const JsonValue* light = find_extension(json, "KHR_lights_punctual"))
          scene_.delta_lights.push_back(gltf_light(document_, *light, nodes.world_from_node(node), rule));
      } catch (const GltfError& error) {
        report(error);
      }
      task.advance(1);
    }
    std::erase_if(scene_.delta_lights, [](const DeltaLight& l) { return l.intensity.value == glm::dvec3(0.0); });
    if (!scene_.delta_lights.empty() && rule.unit != 1.0)
      sink_.note(scene_.position, fmt::format("lamps are divided by {}, because Blender multiplies them by it; --lamps "
                                              "standard shows them as they are written",
                                              rule.unit));
  }

  void show_mesh(const GltfNodes& nodes, std::uint32_t node, const std::vector<GltfPart>& parts) {
    if (parts.empty()) return;
    const JsonValue& json = nodes.json(node);
    const JsonValue* instancing = find_extension(json, "EXT_mesh_gpu_instancing");
    const glm::dmat4 world = GltfMeshes::has_skin(json) ? glm::dmat4(1.0) : nodes.world_from_node(node);
    if (instancing == nullptr) return add_instances(nodes, node, parts, world);
    for (const glm::dmat4& node_from_instance : instances_of(*instancing))
      add_instances(nodes, node, parts, world * node_from_instance);
  }

  void add_instances(const GltfNodes& nodes, std::uint32_t node, const std::vector<GltfPart>& parts,
                     const glm::dmat4& world) {
    const glm::dvec3 x(world[0]), y(world[1]), z(world[2]);
    if (glm::dot(glm::cross(x, y), z) == 0.0) {
      ++flat_;
      return;
    }
    for (const GltfPart& part : parts) {
      if (scene_.instances.size() == kMaxInstances)
        throw GltfError{&nodes.json(node), fmt::format("the scene has more than {} instances", kMaxInstances)};
      scene_.instances.push_back({.shape = part.shape,
                                  .material = part.surface.material,
                                  .emitter = part.surface.emitter,
                                  .world_from_object = world,
                                  .name = nodes.name(node),
                                  .position = document_.position(nodes.json(node))});
    }
  }

  /// A table with a row for each instance; empty if the attribute is missing.
  FloatTable instance_table(const JsonValue& attributes, const char* name, std::uint32_t components) {
    const auto index = find_index(attributes, name);
    return index ? accessors_.floats(*index, attributes, {components}) : FloatTable{};
  }

  std::vector<glm::dmat4> instances_of(const JsonValue& extension) {
    const JsonValue* attributes = find_object(extension, "attributes");
    if (attributes == nullptr) throw GltfError{&extension, "the instances have no \"attributes\""};
    const FloatTable translations = instance_table(*attributes, "TRANSLATION", 3);
    const FloatTable rotations = instance_table(*attributes, "ROTATION", 4);
    const FloatTable scales = instance_table(*attributes, "SCALE", 3);
    const std::size_t count = std::max({translations.rows(), rotations.rows(), scales.rows()});
    for (const FloatTable* table : {&translations, &rotations, &scales}) {
      if (table->components != 0 && table->rows() != count)
        throw GltfError{attributes,
                        fmt::format("the attributes of instances have {} and {} rows", table->rows(), count)};
    }
    if (count > kMaxInstances)
      throw GltfError{attributes,
                      fmt::format("the node has {} instances; at most {} are supported", count, kMaxInstances)};
    std::vector<glm::dmat4> result;
    for (std::size_t i = 0; i < count; ++i) {
      const auto vec3 = [&](const FloatTable& t, double otherwise) {
        return t.components == 0 ? glm::dvec3(otherwise) : glm::dvec3(t.row(i)[0], t.row(i)[1], t.row(i)[2]);
      };
      const glm::dvec4 rotation = rotations.components == 0 ? glm::dvec4(0.0, 0.0, 0.0, 1.0)
                                                            : glm::dvec4(rotations.row(i)[0], rotations.row(i)[1],
                                                                         rotations.row(i)[2], rotations.row(i)[3]);
      result.push_back(gltf_transform(vec3(translations, 0.0), rotation, vec3(scales, 1.0)));
    }
    return result;
  }

  void choose_camera(const GltfNodes& nodes) {
    const bool placed = is_camera_placement(options_.camera);  // the caller does that later
    const bool chosen = !options_.camera.empty() && !placed;
    if (cameras_.empty() && !chosen) {
      frame_camera(scene_);
      if (!placed)
        sink_.warning(scene_.position, "the asset has no camera; one that frames it is used; --camera sets another");
      return;
    }
    std::vector<std::string> names;
    for (const std::uint32_t node : cameras_) names.push_back(nodes.name(node));
    const std::uint32_t which = chosen ? chosen_camera(nodes, names) : 0;
    if (cameras_.size() > 1 && options_.camera.empty())
      sink_.note(scene_.position, fmt::format("the scene has {} cameras and is shown from {}; --camera chooses another",
                                              names.size(), text::quoted(names[0])));
    const std::uint32_t node = cameras_[which];
    const JsonValue& json = nodes.json(node);
    const JsonValue& camera = document_.element("cameras", *find_index(json, "camera"), json);
    scene_.camera.position = document_.position(camera);
    set_gltf_camera(camera, nodes.world_from_node(node), scene_.camera);
  }

  /// The camera that was asked for, by the name of its node, its own name or its number.
  std::uint32_t chosen_camera(const GltfNodes& nodes, const std::vector<std::string>& names) {
    for (std::uint32_t i = 0; i < cameras_.size(); ++i) {
      const JsonValue& json = nodes.json(cameras_[i]);
      if (names[i] == options_.camera) return i;
      if (string_or(document_.element("cameras", *find_index(json, "camera"), json), "name", "") == options_.camera)
        return i;
    }
    return chosen(options_.camera, names, "--camera");
  }

  /// A glowing surface counts as lighting only if there is a camera, too: without one this is a model, not a room, and
  /// is lit like other models.
  void add_light() {
    const bool lit = !scene_.delta_lights.empty() || (!scene_.emitters.empty() && !cameras_.empty());
    if (lit || !options_.environment.empty()) return;
    add_studio_sky(scene_);
    sink_.warning(scene_.position, "the asset has no lamps; a soft grey sky lights it; --environment sets another");
  }

  void say_what_is_left_out(const GltfMeshes& meshes) {
    if (meshes.left_out() > 0)
      sink_.warning(document_.position(*meshes.first_left_out()),
                    fmt::format("{} primitives are points or lines, which have no surface; they are "
                                "left out",
                                meshes.left_out()));
    if (flat_ > 0)
      sink_.note(scene_.position, fmt::format("{} nodes are scaled to zero along an axis; they are left out", flat_));
    if (!options_.at && !array_of(document_.root(), "animations").empty())
      sink_.note(scene_.position,
                 "the animations of the asset are not played: it is shown as its nodes define it; --at TIME shows it "
                 "at a given time");
  }

  GltfDocument& document_;
  const ReadOptions& options_;
  Diagnostics& sink_;
  Scene scene_;
  Accessors accessors_;
  GltfTextures textures_;
  GltfSurfaces surfaces_;
  std::vector<std::uint32_t> cameras_;  ///< nodes
  std::size_t flat_ = 0;
};

}  // namespace

std::optional<Scene> read_gltf(std::shared_ptr<const ByteStore> bytes, const std::string& path, GltfFileOpener open,
                               const ReadOptions& options, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  std::optional<Scene> scene;
  try {
    GltfDocument document(path, std::move(bytes), std::move(open));
    scene = GltfReader(document, options, diagnostics).read();
  } catch (const Error& error) {
    diagnostics.error({}, error.what(), error.kind());
  }
  if (scene && diagnostics.error_count() == errors_before) check_invariants(*scene, diagnostics);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return scene;
}

std::optional<Scene> read_gltf(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics) {
  const std::string folder = fs::path(path).parent_path().string();
  try {
    return read_gltf(
        open_store(path), path, [folder](const std::string& uri) { return open_store(path_of_uri(folder, uri)); },
        options, diagnostics);
  } catch (const Error& error) {
    diagnostics.error({}, error.what(), error.kind());
    return std::nullopt;
  }
}

}  // namespace etendue
