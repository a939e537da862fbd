#include "formats/nori/nori_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/text.h"
#include "formats/dialect/mesh_facts.h"
#include "formats/dialect/mesh_needs.h"
#include "formats/dialect/object.h"
#include "formats/mesh/builtin_meshes.h"
#include "formats/nori/daylight_reader.h"
#include "formats/nori/delta_light_reader.h"
#include "formats/nori/named_files.h"
#include "formats/nori/plugins.h"
#include "formats/nori/texture_reader.h"
#include "formats/xml/xml_document.h"
#include "image/vectors.h"
#include "scene/invariants.h"
#include "scene/limits.h"
#include "scene/materials.h"
#include "scene/metals.h"
#include "scene/parameters.h"
#include "scene/similarity.h"
#include "scene/test_patch.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

/// Number of errors after which no more meshes are opened, so that a file that names one broken mesh a million times
/// ends soon.
constexpr std::size_t kMaxErrorsBeforeMeshes = 100;
/// Limit on the bytes of all mesh files together: some minutes of reading.
constexpr std::uintmax_t kMaxMeshBytes = std::uintmax_t{1} << 34;

std::uint32_t to_uint32(std::int64_t value) {
  return static_cast<std::uint32_t>(value);
}  // in range by the plugin table

/// Turns elements into the structs of scene.h. Every function reports what is wrong and continues with something
/// usable, so that one pass finds all problems; results are valid only if there were no errors.
class SceneReader {
 public:
  SceneReader(ReadContext& context, const MeshLoader& load_mesh)
      : context_(context),
        sink_(context.diagnostics),
        load_mesh_(load_mesh),
        path_(context.document.file()),
        files_(path_, sink_),
        textures_(context, files_) {}

  std::optional<SceneFile> read(const XmlElement& root) {
    if (root.name != "scene" && root.name != "test") {
      sink_.error(
          context_.document.position(root.offset),
          fmt::format("the root element is {}; a file holds one <scene> or one <test>", text::quoted(root.name)));
      return std::nullopt;
    }
    const std::optional<Object> object = Object::read(root, context_);
    if (!object) return std::nullopt;
    const std::string type = object->plugin().type;
    if (type == "ttest") return read_ttest(*object);
    if (type == "chi2test") return read_chi2test(*object);
    return read_scene(*object, fs::path(path_).stem().string());
  }

 private:
  Scene read_scene(const Object& object, const std::string& name) {
    Scene scene;
    scene.name = name;
    scene.file = path_;
    scene.position = object.position();
    scene.sky = {object.get<glm::dvec3>("sky_top"), object.get<glm::dvec3>("sky_horizon")};
    if (const auto integrator = read_integrator_object(object)) read_integrator(*integrator, object, scene);
    if (const auto camera = read_only_child(object, "camera")) scene.camera = read_camera(*camera);
    scene.sampler = read_sampler(object);
    scene.instancing = read_instancing(object);
    materials_.clear();
    textures_.begin_scene();
    read_lights(object, scene);
    meshes_.clear();
    groups_.clear();
    for (const XmlElement* mesh : object.children("mesh")) read_placed(*mesh, scene);
    check_unused_groups(object, scene);
    report_empty_meshes(scene);
    check_unused_definitions(object);
    remember_fields(object, {"sky_top", "sky_horizon"});
    round_to_similarities(scene);
    check_scene(scene);
    return scene;
  }

  void check_scene(const Scene& scene) {
    check_invariants(scene, sink_, [this](const SourcePosition& where, std::string_view field) {
      const auto found = fields_.find({where.line, where.column, std::string(field)});
      return found == fields_.end() ? std::nullopt : std::optional(found->second);
    });
  }

  /// Where the file gives fields of scene.h that are checked once the scene is whole; properties have the same names
  /// in camel case.
  void remember_fields(const Object& object, std::initializer_list<const char*> names) {
    for (const char* name : names) remember_field(object, name, name);
  }
  void remember_field(const Object& object, const char* property, const char* field) {
    if (object.given(property))
      fields_[{object.position().line, object.position().column, field}] = object.position_of(property);
  }

  /// The only object of a tag; nothing if it is missing or unusable.
  std::optional<Object> read_only_child(const Object& parent, const char* tag) {
    const std::vector<const XmlElement*> children = parent.children(tag);
    if (children.empty()) return std::nullopt;
    return Object::read(*children.front(), context_);
  }

  std::optional<Object> read_integrator_object(const Object& root) {
    const std::vector<const XmlElement*> children = root.children("integrator");
    if (children.empty()) return default_integrator(root);
    if (!context_.approximate || !is_unknown(*children.front())) return read_only_child(root, "integrator");
    const SourcePosition position = context_.document.position(children.front()->offset);
    context_.approximated(fmt::format("integrator {}", children.front()->find("type")->value), "path_mis", position);
    return Object::defaulted("integrator", "path_mis", position, context_);
  }

  /// One course's scenes name a sky and leave the integrator to the renderer.
  std::optional<Object> default_integrator(const Object& root) {
    if (!root.given("envmap")) {
      sink_.error(root.position(), fmt::format("<scene> needs a <integrator>; supported types are: {}",
                                               text::join(context_.dialect.types_of("integrator"))));
      return std::nullopt;
    }
    sink_.note(root.position(), "the scene has no integrator; it is rendered with path_mis");
    return Object::defaulted("integrator", "path_mis", root.position(), context_);
  }

  void read_integrator(const Object& object, const Object& root, Scene& scene) {
    scene.integrator = read_integrator(object, root);
    if (object.plugin().find("hideBackground") != nullptr)
      scene.integrator.hide_background = object.get<bool>("hideBackground");
    try {
      scene.aovs = parse_aovs(object.get<std::string>("aovs"));
    } catch (const Error& error) {
      sink_.error(object.position_of("aovs"), error.what());
    }
  }

  Integrator read_integrator(const Object& object, const Object& scene) {
    const std::string type = object.plugin().type;
    if (object.plugin().find("maxDepth") != nullptr) return read_path(object, scene, type);
    const bool gathers = type.starts_with("direct") || type == "whitted";
    if (gathers && scene.given("nee")) warn_scene_nee(scene, "the integrator " + type + " decides it");
    Integrator integrator = gathers ? read_direct(object, type) : read_first_hit(object, type);
    if (object.plugin().find("hideEmitters") != nullptr) integrator.hide_emitters = object.get<bool>("hideEmitters");
    if (object.plugin().find("lightSampler") != nullptr) integrator.light_sampler = read_light_sampler(object);
    return integrator;
  }

  /// `path`, and the types that are other names for it.
  Integrator read_path(const Object& object, const Object& scene, const std::string& type) {
    Integrator integrator;
    integrator.max_depth = to_uint32(object.get<std::int64_t>("maxDepth"));
    integrator.rr_depth = to_uint32(object.get<std::int64_t>("rrDepth"));
    integrator.hide_emitters = object.get<bool>("hideEmitters");
    if (type == "path") {
      // The scene's nee counts only if the integrator has none.
      integrator.nee = object.given("nee") ? object.get<bool>("nee") : scene.get<bool>("nee");
      integrator.mis = object.get<bool>("mis");
      integrator.count_passes = object.get<bool>("countPasses");
      if (object.given("nee") && scene.given("nee")) warn_scene_nee(scene, "the integrator has its own");
    } else {
      note_other_integrator(object, type);
      integrator.nee = !type.ends_with("mats") && type != "path_simple";
      integrator.mis = integrator.nee && type != "path_ems";
      integrator.count_passes = type.find("vol") == std::string::npos;
      if (scene.given("nee") && scene.get<bool>("nee") != integrator.nee)
        warn_scene_nee(scene, "the integrator " + type + " decides it");
    }
    integrator.light_sampler = read_light_sampler(object);
    check_integrator(integrator, object);
    return integrator;
  }

  void note_other_integrator(const Object& object, const std::string& type) {
    if (type == "photonmapper" || type == "bdpt" || type == "mlt")
      sink_.note(object.position(),
                 fmt::format("the integrator {} is read as path_mis: the same light, but different noise", type));
  }

  Integrator read_direct(const Object& object, const std::string& type) {
    Integrator integrator;
    integrator.type = type == "whitted" ? Integrator::Type::whitted : Integrator::Type::direct;
    if (type == "direct_ems") integrator.bsdf_samples = 0;
    if (type == "direct_mats") integrator.emitter_samples = 0;
    if (type != "direct") return integrator;
    integrator.emitter_samples = to_uint32(object.get<std::int64_t>("emitterSamples"));
    integrator.bsdf_samples = to_uint32(object.get<std::int64_t>("bsdfSamples"));
    if (integrator.emitter_samples + integrator.bsdf_samples == 0)
      sink_.error(object.position_of("bsdfSamples"),
                  "neither emitterSamples nor bsdfSamples is above 0: nothing would be lit; set one of them to 1");
    return integrator;
  }

  Integrator read_first_hit(const Object& object, const std::string& type) {
    using enum Integrator::Type;
    Integrator integrator;
    if (type == "normals") {
      integrator.type = object.get<bool>("signed") ? normals : absolute_normals;
    } else if (type == "depth") {
      integrator.type = depth;
    } else if (type == "distance") {
      integrator.type = distance;
    } else if (type == "simple") {
      integrator.type = simple;
      integrator.light = {object.get<glm::dvec3>("position"), object.get<glm::dvec3>("energy")};
    } else {
      integrator.type = type == "av" ? visibility : ambient_occlusion;
      if (const auto length = object.get<double>("length"); length > 0.0) integrator.length = length;
    }
    return integrator;
  }

  Integrator::LightSampler read_light_sampler(const Object& object) {
    using enum Integrator::LightSampler;
    const auto text = object.get<std::string>("lightSampler");
    if (text == "power") return power;
    if (text == "tree") return tree;
    if (text != "auto") {
      const std::vector<std::string> known = {"auto", "power", "tree"};
      sink_.error(object.position_of("lightSampler"),
                  fmt::format("{} is not a way to choose lights{}; known are auto, power and tree", text::quoted(text),
                              text::did_you_mean(text, known)));
    }
    return automatic;
  }

  void warn_scene_nee(const Object& scene, const std::string& why) {
    sink_.warning(scene.position_of("nee"), fmt::format("\"nee\" of <scene> has no effect: {}", why));
  }

  void check_integrator(const Integrator& integrator, const Object& object) {
    const bool path = std::string_view(object.plugin().type) == "path";
    if (path && !integrator.nee && object.given("mis") && integrator.mis) {
      sink_.warning(object.position_of("mis"), "\"mis\" has no effect without nee; set nee to true or remove mis");
    }
    if (object.given("rrDepth") && integrator.rr_depth > integrator.max_depth) {
      sink_.warning(object.position_of("rrDepth"), fmt::format("\"rrDepth\" {} has no effect: paths end at maxDepth {}",
                                                               integrator.rr_depth, integrator.max_depth));
    }
    constexpr std::uint32_t kLongPath = 10000;
    if (integrator.rr_depth == 0 && integrator.max_depth > kLongPath) {
      sink_.warning(
          object.position_of("maxDepth"),
          fmt::format("paths of up to {} segments without Russian roulette may take for ever; set rrDepth to 5",
                      integrator.max_depth));
    }
  }

  Camera read_camera(const Object& object) {
    Camera camera;
    camera.position = object.position();
    const auto width = object.get<std::int64_t>("width"), height = object.get<std::int64_t>("height");
    camera.width = to_uint32(width);
    camera.height = to_uint32(height);
    camera.type = camera_type(object.plugin().type);
    if (object.plugin().find("fov") != nullptr) read_field_of_view(object, camera);
    if (object.plugin().find("apertureRadius") != nullptr) read_lens(object, camera);
    read_crop(object, camera);
    camera.near_clip = object.get<double>("nearClip");
    camera.far_clip = object.get<double>("farClip");
    camera.world_from_camera = object.matrix("toWorld");
    remember_fields(object, {"width", "fov"});
    remember_field(object, "nearClip", "near_clip");
    remember_field(object, "farClip", "far_clip");
    remember_field(object, "toWorld", "world_from_camera");
    camera.filter = read_filter(object);
    read_path_of_camera(object, camera);
    return camera;
  }

  void read_path_of_camera(const Object& object, Camera& camera) {
    const auto curve = object.get<std::string>("path");
    if (curve != "spline" && curve != "linear")
      sink_.error(object.position_of("path"),
                  fmt::format("{} is not a path between keyframes{}; known are spline and linear", text::quoted(curve),
                              text::did_you_mean(curve, {"spline", "linear"})));
    camera.path.curve = curve == "linear" ? CameraPath::Curve::linear : CameraPath::Curve::spline;
    for (const XmlElement* element : object.children("keyframe")) {
      const std::size_t errors_before = sink_.error_count();
      const auto key = Object::read(*element, context_);
      if (!key || sink_.error_count() > errors_before) continue;
      camera.path.keys.push_back({key->get<double>("time"), key->matrix("toWorld")});
      // Each one is compared with the previous ones, so that the position of an error is known.
      if (const std::string complaint = key_complaint(camera.path, camera.path.keys.size() - 1); !complaint.empty()) {
        sink_.error(key->position_of(complaint.find(" is at ") == std::string::npos ? "toWorld" : "time"), complaint);
        camera.path.keys.pop_back();
      }
    }
    if (camera.path.empty()) return;
    if (object.given("toWorld"))
      sink_.error(object.position_of("toWorld"),
                  "the camera has both \"toWorld\" and keyframes, which both place it; keep one of them");
    camera.world_from_camera = pose_at(camera.path, 0.0);
  }

  /// For thinlens, and for perspective, to which courses give a lens instead of using another camera.
  void read_lens(const Object& object, Camera& camera) {
    const auto radius = object.get<double>("apertureRadius");
    if (camera.type == Camera::Type::thin_lens) {
      camera.aperture = {radius, object.get<double>("focusDistance"), to_uint32(object.get<std::int64_t>("blades")),
                         object.get<double>("bladeRotation")};
      return;
    }
    if (!(radius > 0.0) || !object.get<bool>("dof")) return;
    if (is_focus_distance(object)) {
      sink_.note(object.position_of("focalLength"), "\"focalLength\" next to \"fov\" is read as \"focusDistance\"");
      camera.type = Camera::Type::thin_lens;
      camera.aperture = {.radius = radius, .focus_distance = object.get<double>("focalLength")};
      return;
    }
    if (!object.given("focusDistance"))
      return sink_.error(object.position_of("apertureRadius"),
                         "a lens needs a focus distance; add <float name=\"focusDistance\" value=\"…\"/>");
    camera.type = Camera::Type::thin_lens;
    camera.aperture = {.radius = radius, .focus_distance = object.get<double>("focusDistance")};
  }

  static Camera::Type camera_type(std::string_view type) {
    using enum Camera::Type;
    if (type == "perspective") return perspective;
    if (type == "thinlens") return thin_lens;
    if (type == "orthographic") return orthographic;
    if (type == "spherical") return spherical;
    if (type == "radiancemeter") return radiance_meter;
    if (type == "irradiancemeter") return irradiance_meter;
    throw std::logic_error(fmt::format("the reader has no camera {}", type));
  }

  void read_field_of_view(const Object& object, Camera& camera) {
    camera.fov = object.get<double>("fov");
    camera.window.principal_offset = {object.get<double>("principalPointOffsetX"),
                                      object.get<double>("principalPointOffsetY")};
    using enum Camera::FovAxis;
    const std::map<std::string, Camera::FovAxis> axes = {
        {"x", x}, {"y", y}, {"diagonal", diagonal}, {"smaller", smaller}, {"larger", larger}};
    const auto text = object.get<std::string>("fovAxis");
    if (const auto found = axes.find(text); found != axes.end()) {
      camera.fov_axis = found->second;
    } else {
      sink_.error(
          object.position_of("fovAxis"),
          fmt::format("{} is not an axis of the field of view{}; known are x, y, diagonal, smaller and larger",
                      text::quoted(text), text::did_you_mean(text, {"x", "y", "diagonal", "smaller", "larger"})));
    }
    const auto focal_length = object.get<double>("focalLength");
    if (!(focal_length > 0.0) || is_focus_distance(object)) return;
    const bool both = object.given("fov") || object.given("fovAxis");
    if (both)
      sink_.error(object.position_of("focalLength"),
                  "\"focalLength\" and \"fov\" both say how wide the view is; keep one");
    constexpr double kDegrees = 180.0 / 3.14159265358979323846;
    camera.fov = 2.0 * std::atan(std::hypot(36.0, 24.0) / (2.0 * focal_length)) * kDegrees;
    camera.fov_axis = diagonal;
  }

  /// One course calls the focus distance focalLength; for a lens with a known field of view it cannot mean anything
  /// else.
  static bool is_focus_distance(const Object& object) {
    return object.given("focalLength") && object.given("fov") && object.given("apertureRadius") &&
           !object.given("focusDistance");
  }

  /// The rendered part of the film becomes the film, and its position is kept.
  void read_crop(const Object& object, Camera& camera) {
    const auto offset_x = object.get<std::int64_t>("cropOffsetX"), offset_y = object.get<std::int64_t>("cropOffsetY");
    const auto size = [&](const char* name, std::int64_t offset, std::uint32_t whole) {
      const auto wanted = object.get<std::int64_t>(name);
      const std::int64_t pixels = wanted > 0 ? wanted : whole - offset;
      if (offset < whole && offset + pixels <= whole) return static_cast<std::uint32_t>(pixels);
      sink_.error(object.position_of(wanted > 0                              ? name
                                     : name == std::string_view("cropWidth") ? "cropOffsetX"
                                                                             : "cropOffsetY"),
                  fmt::format("{} pixels from pixel {} on do not fit into a film of {}",
                              std::max<std::int64_t>(pixels, 1), offset, whole));
      return whole;
    };
    const glm::dvec2 whole(camera.width, camera.height);
    const std::uint32_t width = size("cropWidth", offset_x, camera.width);
    const std::uint32_t height = size("cropHeight", offset_y, camera.height);
    camera.window.origin = glm::dvec2(offset_x, offset_y) / whole;
    camera.window.size = glm::dvec2(width, height) / whole;
    camera.width = width;
    camera.height = height;
  }

  ReconstructionFilter read_filter(const Object& camera) {
    ReconstructionFilter filter;
    std::optional<Object> object = read_only_child(camera, "rfilter");
    if (!object && !camera.children("rfilter").empty()) return filter;
    // As in Nori, whose tests count samples without a film.
    if (!object) object = Object::defaulted("rfilter", in_test_ ? "box" : "gaussian", camera.position(), context_);
    const std::string_view type = object->plugin().type;
    using Type = ReconstructionFilter::Type;
    filter.type = type == "tent"       ? Type::tent
                  : type == "gaussian" ? Type::gaussian
                  : type == "mitchell" ? Type::mitchell
                  : type == "lanczos"  ? Type::lanczos
                                       : Type::box;
    if (filter.type == Type::gaussian || filter.type == Type::mitchell) filter.radius = object->get<double>("radius");
    if (filter.type == Type::gaussian) filter.stddev = object->get<double>("stddev");
    if (filter.type == Type::box) filter.stretch = object->get<double>("radius") / 0.5;
    if (filter.type == Type::tent) filter.stretch = object->get<double>("radius");
    if (filter.type == Type::lanczos) filter.lobes = to_uint32(object->get<std::int64_t>("lobes"));
    if (filter.type == Type::mitchell) {
      filter.b = object->get<double>("B");
      filter.c = object->get<double>("C");
    }
    return filter;
  }

  Sampler read_sampler(const Object& scene) {
    std::optional<Object> object = read_only_child(scene, "sampler");
    if (!object && !scene.children("sampler").empty()) return {};
    if (!object) object = Object::defaulted("sampler", "independent", scene.position(), context_);
    const std::uint32_t count = to_uint32(object->get<std::int64_t>("sampleCount"));
    if (std::string_view(object->plugin().type) != "sobol") return {Sampler::Type::independent, count};
    note_other_sampler(scene);
    const std::uint32_t size = to_uint32(object->get<std::int64_t>("setSize"));
    if (!std::has_single_bit(size)) {
      sink_.error(object->position_of("setSize"), fmt::format("setSize {} is not a power of two; use {} or {}", size,
                                                              std::bit_floor(size), std::bit_ceil(size)));
    }
    return {Sampler::Type::sobol, count, static_cast<std::uint32_t>(std::bit_width(size)) - 1};
  }

  /// All samplers with well-distributed points mean the same here.
  void note_other_sampler(const Object& scene) {
    const std::vector<const XmlElement*> children = scene.children("sampler");
    const XmlAttribute* type = children.empty() ? nullptr : children.front()->find("type");
    if (type == nullptr || context_.dialect.canonical_type("sampler", type->value) == type->value) return;
    sink_.note(value_position(*type, 0, context_),
               fmt::format("the sampler {} is read as sobol: scrambled Sobol points in independent sets", type->value));
  }

  Instancing read_instancing(const Object& object) {
    const auto text = object.get<std::string>("instancing");
    if (text == "never") return Instancing::never;
    if (text == "always") return Instancing::always;
    if (text != "auto") {
      const std::vector<std::string> known = {"auto", "never", "always"};
      sink_.error(object.position_of("instancing"),
                  fmt::format("{} is not a value of \"instancing\"{}; known are auto, never and always",
                              text::quoted(text), text::did_you_mean(text, known)));
    }
    return Instancing::automatic;
  }

  bool is_of_type(const XmlElement& element, std::string_view type) const {
    const XmlAttribute* given = element.find("type");
    return given != nullptr && given->value == type;
  }

  /// A direct child of the scene: a shape, the definition of a group, or an instance of one.
  void read_placed(const XmlElement& element, Scene& scene) {
    if (is_of_type(element, "shapegroup")) {
      if (element.find("id") == nullptr)
        sink_.error(
            context_.document.position(element.offset),
            fmt::format("the shape group needs an id, or no instance can show it; write <{} type=\"shapegroup\" "
                        "id=\"…\">",
                        element.name));
      return;
    }
    const auto object = Object::read(element, context_);
    if (!object) return;
    if (is_of_type(element, "instance")) return read_group_instance(*object, scene);
    if (std::optional<Instance> instance = read_instance(*object, scene))
      scene.instances.push_back(std::move(*instance));
  }

  /// An instance of a group means an instance of each of its shapes.
  void read_group_instance(const Object& object, Scene& scene) {
    const std::vector<const XmlElement*> children = object.children("mesh");
    if (children.empty()) {
      sink_.error(object.position(),
                  "the instance shows nothing; add <ref id=\"…\"/> with the id of a <shape type=\"shapegroup\">");
      return;
    }
    const XmlElement& group = *children.front();
    if (!is_of_type(group, "shapegroup")) {
      sink_.error(object.position(),
                  fmt::format("an instance shows a <shape type=\"shapegroup\">, but this refers to a <{}> of another "
                              "type; put that into a group",
                              group.name));
      return;
    }
    const glm::dmat4 placed = object.matrix("toWorld");
    remember_field(object, "toWorld", "world_from_object");
    for (const Instance& member : read_group(group, scene)) {
      Instance& instance = scene.instances.emplace_back(member);
      instance.world_from_object = placed * member.world_from_object;
      instance.position = object.position();
    }
  }

  /// The shapes of a group, placed in its space. Read once.
  const std::vector<Instance>& read_group(const XmlElement& element, Scene& scene) {
    const auto [found, is_new] = groups_.try_emplace(&element);
    if (!is_new) return found->second;
    std::vector<Instance> members;
    if (const auto group = Object::read(element, context_)) {
      for (const XmlElement* mesh : group->children("mesh")) {
        if (is_of_type(*mesh, "instance") || is_of_type(*mesh, "shapegroup")) {
          sink_.error(context_.document.position(mesh->offset),
                      "a shape group holds shapes, no instances or other groups: instances are one level deep");
          continue;
        }
        const auto object = Object::read(*mesh, context_);
        if (!object) continue;
        if (std::optional<Instance> member = read_instance(*object, scene)) members.push_back(std::move(*member));
      }
    }
    return groups_[&element] = std::move(members);
  }

  void check_unused_groups(const Object& object, Scene& scene) {
    for (const XmlElement* element : object.children("mesh")) {
      const XmlAttribute* id = element->find("id");
      if (!is_of_type(*element, "shapegroup") || id == nullptr || context_.references.is_used(id->value)) continue;
      sink_.warning(
          context_.document.position(element->offset),
          fmt::format("no instance shows the shape group {}; add <shape type=\"instance\"><ref id={}/></shape>, "
                      "or remove it",
                      text::quoted(id->value), text::quoted(id->value)));
      read_group(*element, scene);  // to report its errors
    }
  }

  std::optional<Instance> read_instance(const Object& object, Scene& scene) {
    const std::uint32_t material = material_of(object, scene);
    std::optional<AreaEmitter> area_emitter;
    const auto emitter = read_only_child(object, "emitter");
    if (emitter && std::string_view(emitter->plugin().type) == "envmap") return read_sky_mesh(*emitter, scene);
    if (emitter) area_emitter = read_emitter(*emitter, scene);
    std::string name = object.plugin().type;
    const AreaEmitter* shine = area_emitter ? &*area_emitter : nullptr;
    const std::optional<std::uint32_t> shape =
        read_shape(object, content_for(material, shine, scene, context_.shows_uv), name, scene);
    if (!shape) return std::nullopt;
    Instance instance;
    instance.material = material;
    if (area_emitter) {
      instance.emitter = static_cast<std::uint32_t>(scene.emitters.size());
      scene.emitters.push_back(*area_emitter);
    }
    instance.shape = *shape;
    instance.name = std::move(name);
    instance.position = object.position();
    if (object.plugin().find("toWorld") != nullptr) instance.world_from_object = object.matrix("toWorld");
    if (object.plugin().find("flipNormals") != nullptr) instance.flip_normals = object.get<bool>("flipNormals");
    remember_field(object, "toWorld", "world_from_object");
    turn_in_place(object, scene.shapes[instance.shape], instance.world_from_object);
    return instance;
  }

  /// In courses, spheres stay where their center is: a transform that only rotates is meant for their textures. A
  /// <matrix> means what it says.
  void turn_in_place(const Object& object, const Shape& shape, glm::dmat4& world_from_object) {
    const auto* sphere = std::get_if<Sphere>(&shape);
    const glm::dmat3 linear(world_from_object);
    constexpr double kTolerance = 1e-6;
    if (sphere == nullptr || !object.given("toWorld") || object.is_matrix("toWorld") ||
        sphere->center == glm::dvec3(0.0))
      return;
    if (glm::length(glm::dvec3(world_from_object[3])) > kTolerance) return;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        if (std::abs(glm::dot(linear[i], linear[j]) - (i == j ? 1.0 : 0.0)) > kTolerance) return;
      }
    }
    sink_.note(object.position_of("toWorld"), "this transform only rotates: it turns the sphere about its center");
    world_from_object[3] = glm::dvec4(sphere->center - linear * sphere->center, 1.0);
  }

  /// The row of the material of a mesh, with what the mesh itself says about it.
  std::uint32_t material_of(const Object& mesh, Scene& scene) {
    const std::vector<const XmlElement*> bsdfs = mesh.children("bsdf");
    std::uint32_t row =
        bsdfs.empty() ? add_material({.bsdf = DiffuseBsdf{}, .name = "diffuse", .position = mesh.position()}, scene)
                      : material_row(*bsdfs.front(), scene);
    if (has_map(mesh, "texture")) row = repaint(mesh, row, scene);
    return with_normals(mesh, row, scene);
  }

  /// A copy of a material with the texture of a mesh in the place of its colour.
  std::uint32_t repaint(const Object& mesh, std::uint32_t row, Scene& scene) {
    const ColorParameter color = read_textured(mesh, "texture", &scene);
    Material material = scene.materials[row];
    const auto set = [&](auto& bsdf) {
      if constexpr (requires { bsdf.albedo; })
        bsdf.albedo = color;
      else if constexpr (requires { bsdf.kd; })
        bsdf.kd = color;
      else if constexpr (requires { bsdf.base_color; })
        bsdf.base_color = color;
      else if constexpr (requires { bsdf.diffuse_reflectance; })
        bsdf.diffuse_reflectance = color;
      else
        sink_.error(mesh.position_of("texture"),
                    fmt::format("the material {} has no colour that this texture could be; put it into the material",
                                text::quoted(material.name)));
    };
    if (material.adapter)
      sink_.error(mesh.position_of("texture"),
                  "the material holds others; put the texture into the one it is meant for");
    else
      std::visit(set, material.bsdf);
    return add_material(std::move(material), scene);
  }

  /// The row of the material under the shading normals that its object, or a mesh, has; without any, the same row.
  std::uint32_t with_normals(const Object& owner, std::uint32_t row, Scene& scene) {
    if (owner.plugin().find("normals") == nullptr || !has_map(owner, "normals")) return row;
    const ColorParameter normals = read_textured(owner, "normals", &scene);
    if (normals.texture && !says_raw(*owner.child_of("normals"))) {
      if (auto* picture = std::get_if<BitmapTexture>(&scene.textures[*normals.texture].source))
        picture->color_space = ColorSpace::linear;
    }
    const TurnedNormals turned{.mirrored = false, .shadowed = false};
    return add_material({.adapter = NormalMapAdapter{normals, row, false, turned},
                         .name = "normals",
                         .position = owner.position_of("normals")},
                        scene);
  }
  static bool says_raw(const XmlElement& texture) {
    return std::ranges::any_of(texture.children, [](const XmlElement& child) {
      const XmlAttribute* name = child.find("name");
      return name != nullptr && name->value == "raw";
    });
  }

  /// The row of the material with the holes that its object gives it; without any, the same row.
  std::uint32_t with_opacity(const Object& owner, std::uint32_t row, Scene& scene) {
    if (owner.plugin().find("opacity") == nullptr || is_adapter(owner.plugin().type) || !owner.given("opacity"))
      return row;
    const ScalarParameter opacity = read_scalar(owner, "opacity", &scene);
    return add_material(
        {.adapter = MaskAdapter{opacity, row}, .name = "opacity", .position = owner.position_of("opacity")}, scene);
  }

  /// The row in the scene's shapes: a new one, or that of a mesh file read before.
  std::optional<std::uint32_t> read_shape(const Object& object, const MeshContent& content, std::string& name,
                                          Scene& scene) {
    const std::string file = mesh_file_key(object, content);
    if (const auto known = meshes_.find(file); known != meshes_.end()) {
      name = known->second.name;
      return known->second.shape;
    }
    std::optional<Shape> shape = make_shape(object, content, name);
    if (!shape) return std::nullopt;
    const auto row = static_cast<std::uint32_t>(scene.shapes.size());
    scene.shapes.push_back(std::move(*shape));
    if (!file.empty()) meshes_.emplace(file, LoadedMesh{row, name});
    return row;
  }

  /// A key that is equal if two objects show the same mesh: the file and how it is read. "" for anything but mesh
  /// files.
  std::string mesh_file_key(const Object& object, const MeshContent& content) {
    const std::string_view type = object.plugin().type;
    if (find_mesh_format(type) == nullptr || !object.given("filename")) return "";
    return fmt::format("{}:{}{}:{}", type, content.uv ? "u" : "", content.colors ? "c" : "",
                       text::trim(object.get<std::string>("filename")));
  }

  std::optional<Shape> make_shape(const Object& object, const MeshContent& content, std::string& name) {
    const std::string_view type = object.plugin().type;
    if (const MeshFormat* format = find_mesh_format(type)) {
      std::optional<TriangleMesh> mesh = read_mesh(object, *format, content, name);
      if (!mesh) return std::nullopt;
      if (mesh->triangles.empty()) {
        empty_meshes_.push_back({object.position_of("filename"), name});
        return std::nullopt;
      }
      apply_mesh_facts(context_.dialect.mesh_facts, format->states_v, *mesh);
      return std::move(*mesh);
    }
    if (type == "disk") return Disk{};
    if (type == "rectangle" || type == "cube" || type == "parallelogram") {
      TriangleMesh mesh = type == "cube" ? make_cube()
                          : type == "rectangle"
                              ? make_rectangle()
                              : make_parallelogram(object.get<glm::dvec3>("origin"), object.get<glm::dvec3>("u"),
                                                   object.get<glm::dvec3>("v"));
      apply_mesh_facts(context_.dialect.mesh_facts, false, mesh);
      return mesh;
    }
    remember_fields(object, {"radius"});
    if (type == "cylinder") {
      remember_fields(object, {"p1"});
      return Cylinder{object.get<glm::dvec3>("p0"), object.get<glm::dvec3>("p1"), object.get<double>("radius")};
    }
    if (type != "sphere") throw std::logic_error(fmt::format("the reader has no shape {}", type));
    return Sphere{object.get<glm::dvec3>("center"), object.get<double>("radius")};
  }

  static std::uint32_t add_material(Material material, Scene& scene) {
    scene.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(scene.materials.size() - 1);
  }

  /// The row of a <bsdf>, which is read when first needed. The materials inside it come before it.
  std::uint32_t material_row(const XmlElement& element, Scene& scene) {
    if (const auto known = materials_.find(&element); known != materials_.end()) return known->second;
    Material material{.bsdf = DiffuseBsdf{}, .name = "bsdf", .position = context_.document.position(element.offset)};
    std::optional<Object> object;
    if (context_.approximate && is_unknown(element)) {
      material.bsdf = DiffuseBsdf{substitute_color(element)};
    } else if ((object = Object::read(element, context_))) {
      const XmlAttribute* id = element.find("id");
      material.name = id != nullptr ? id->value : object->plugin().type;
      material.position = object->position();
      material.adapter = read_adapter(*object, scene);
      if (!is_adapter(object->plugin().type)) material.bsdf = read_bsdf(*object, &scene);
    }
    std::uint32_t row = add_material(std::move(material), scene);
    if (object) row = with_opacity(*object, with_normals(*object, row, scene), scene);
    materials_.emplace(&element, row);
    return row;
  }

  bool is_unknown(const XmlElement& element) const {
    const XmlAttribute* type = element.find("type");
    return type != nullptr && context_.dialect.find(context_.dialect.canonical(element.name), type->value) == nullptr;
  }

  /// The colour of an unsupported material.
  glm::dvec3 substitute_color(const XmlElement& element) {
    glm::dvec3 color(0.5);
    for (const XmlElement& child : element.children) {
      const XmlAttribute *name = child.find("name"), *value = child.find("value");
      if (child.name != "color" || name == nullptr || value == nullptr) continue;
      static constexpr std::string_view kWords[] = {
          "albedo", "kd", "reflectance", "diffuseReflectance", "base_color", "baseColor", "diffuse_reflectance"};
      if (std::ranges::find(kWords, name->value) == std::end(kWords)) continue;
      try {
        color = parse_triple(value->value, {0.0, 1.0, false, false});
        break;
      } catch (const ValueError& error) {
        sink_.error(value_position(*value, error.offset, context_), error.message);
      }
    }
    context_.approximated(fmt::format("bsdf {}", element.find("type")->value), "diffuse, of its colour or grey",
                          context_.document.position(element.offset));
    return color;
  }

  static TurnedNormals turned_normals(const Object& map) {
    return {.mirrored = map.get<bool>("flip_invalid_normals"), .shadowed = map.get<bool>("use_shadowing_function")};
  }

  /// Nothing for supported materials.
  std::optional<Adapter> read_adapter(const Object& object, Scene& scene) {
    const std::string_view type = object.plugin().type;
    if (!is_adapter(type)) return std::nullopt;
    std::vector<std::uint32_t> rows;
    for (const XmlElement* child : object.children("bsdf")) rows.push_back(material_row(*child, scene));
    if (rows.empty()) return std::nullopt;  // has been reported
    if (type == "twosided") return TwoSidedAdapter{rows.front(), rows.back()};
    std::optional<Adapter> adapter;
    if (type == "normalmap" || type == "bumpmap") {
      const char* property = type == "normalmap" ? "normalmap" : "displacement";
      if (object.child_of(property) == nullptr) {
        sink_.error(object.position_of(property),
                    fmt::format("\"{}\" of {} is a texture; add <texture name=\"{}\" …>", property, type, property));
        return std::nullopt;
      }
      if (type == "normalmap") {
        adapter.emplace(NormalMapAdapter{read_factor(object, property, &scene), rows.front(),
                                         object.get<bool>("vertex_tangents"), turned_normals(object)});
      } else {
        ScalarParameter height = read_scalar(object, property, &scene);
        height.value *= object.get<double>("scale");
        adapter.emplace(BumpMapAdapter{height, rows.front(), turned_normals(object)});
      }
      return adapter;
    }
    const ScalarParameter share = read_scalar(object, type == "mask" ? "opacity" : "weight", &scene);
    if (type == "mask")
      adapter.emplace(MaskAdapter{share, rows.front()});
    else if (type == "mixture")
      adapter.emplace(BlendAdapter{share, rows.back(), rows.front()});
    else
      adapter.emplace(BlendAdapter{share, rows.front(), rows.back()});
    return adapter;
  }
  static bool is_adapter(std::string_view type) {
    return type == "twosided" || type == "mask" || type == "blend" || type == "mixture" || type == "normalmap" ||
           type == "bumpmap";
  }

  /// A number, or the channel of a texture in its place.
  ScalarParameter read_scalar(const Object& object, const char* property, Scene* scene) {
    if (object.child_of(property) == nullptr) {
      remember_fields(object, {property});
      return object.get<double>(property);
    }
    const ColorParameter color = read_textured(object, property, scene);
    if (textures_.constant(object, property)) {
      const TextureChannel channel = textures_.channel_of(object, property);
      if (channel == TextureChannel::alpha) return ScalarParameter(1.0);
      return channel == TextureChannel::luminance ? luminance(color.value) : color.value[static_cast<int>(channel)];
    }
    if (!color.texture) return ScalarParameter(1.0);
    const glm::dvec3& factor = color.value;
    if (factor.x != factor.y || factor.y != factor.z)
      sink_.error(
          object.position_of(property),
          fmt::format("a number takes a texture times a number, not times the colour {} {} {}; use a grey scale",
                      factor.x, factor.y, factor.z));
    return {factor.x, *color.texture, textures_.channel_of(object, property)};
  }

  /// Unused definitions are read as well, to report their errors.
  void check_unused_definitions(const Object& scene) {
    for (const ChildRule& rule : scene.plugin().children) {
      if (rule.use != ChildUse::definition) continue;
      for (const XmlElement* element : scene.children(rule.tag)) {
        const std::string& id = element->find("id")->value;
        if (context_.references.is_used(id)) continue;
        sink_.warning(context_.document.position(element->offset),
                      fmt::format("nothing refers to <{} id={}>; use it by <ref id={}/>, or remove it", element->name,
                                  text::quoted(id), text::quoted(id)));
        Object::read(*element, context_);
      }
    }
  }

  /// Libraries of models often contain a file without a surface; a scene of nothing else is an error.
  void report_empty_meshes(const Scene& scene) {
    for (const EmptyMesh& mesh : std::exchange(empty_meshes_, {})) {
      const std::string what = fmt::format("the mesh {} has no faces", text::quoted(mesh.name));
      if (scene.instances.empty()) {
        sink_.error(mesh.position, what + ", nor has any other; export the surface as faces");
      } else {
        sink_.warning(mesh.position, what + "; it is left out");
      }
    }
  }

  Bsdf read_bsdf(const Object& object, Scene* scene) {
    const std::string_view type = object.plugin().type;
    if (type == "null") return NullBsdf{};
    if (type == "principled") return read_principled(object, scene);
    if (type == "gltf") return read_gltf(object, scene);
    if (type == "principledthin") return read_parameters<PrincipledThinBsdf>(object, scene);
    if (type == "mirror") {
      if (!object.given("albedo")) return MirrorBsdf{};
      return ConductorBsdf{ConductorIndex{}, read_factor(object, "albedo", scene)};
    }
    if (type == "dielectric") {
      return DielectricBsdf{object.get<double>("intIOR"), object.get<double>("extIOR"),
                            read_factor(object, "specular_reflectance", scene),
                            read_factor(object, "specular_transmittance", scene)};
    }
    if (type == "microfacet") return read_microfacet(object, scene);
    if (type == "conductor")
      return ConductorBsdf{read_metal(object, scene), read_factor(object, "specular_reflectance", scene)};
    if (type == "roughconductor")
      return RoughConductorBsdf{read_metal(object, scene), read_roughness(object, scene),
                                read_factor(object, "specular_reflectance", scene)};
    if (type == "roughdielectric") {
      return RoughDielectricBsdf{object.get<double>("intIOR"), object.get<double>("extIOR"),
                                 read_roughness(object, scene), read_factor(object, "specular_reflectance", scene),
                                 read_factor(object, "specular_transmittance", scene)};
    }
    if (type == "thindielectric") {
      return ThinDielectricBsdf{object.get<double>("intIOR"), object.get<double>("extIOR"),
                                read_factor(object, "specular_reflectance", scene),
                                read_factor(object, "specular_transmittance", scene)};
    }
    if (type == "plastic") return read_plastic<PlasticBsdf>(object, scene);
    if (type == "roughplastic") {
      auto plastic = read_plastic<RoughPlasticBsdf>(object, scene);
      plastic.distribution = read_distribution(object);
      plastic.alpha = read_scalar(object, "alpha", scene);
      return plastic;
    }
    if (type != "diffuse") throw std::logic_error(fmt::format("the reader has no material {}", type));
    if (object.child_of("albedo") != nullptr) return DiffuseBsdf{read_textured(object, "albedo", scene)};
    const auto albedo = object.get<glm::dvec3>("albedo");
    const double least = std::min({albedo.x, albedo.y, albedo.z}), most = std::max({albedo.x, albedo.y, albedo.z});
    if (most > 1.0) {
      sink_.warning(object.position_of("albedo"),
                    fmt::format("albedo {} is above 1: the surface reflects more light than it receives, and the image "
                                "may not converge",
                                most));
    }
    if (least < 0.0) {
      sink_.warning(
          object.position_of("albedo"),
          fmt::format("albedo {} is below 0: the surface reflects negative light, which darkens others", least));
    }
    return DiffuseBsdf{albedo};
  }

  /// Of a material whose parameters have the names that they have in the scene.
  template <typename T>
  T read_parameters(const Object& object, Scene* scene) {
    T bsdf;
    each_parameter(bsdf, [&](const char* name, auto& parameter) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameter)>, ColorParameter>) {
        parameter = read_factor(object, name, scene);
      } else {
        parameter = read_scalar(object, name, scene);
      }
    });
    return bsdf;
  }

  PrincipledBsdf read_principled(const Object& object, Scene* scene) {
    auto bsdf = read_parameters<PrincipledBsdf>(object, scene);
    if (object.given("specular") && !object.given("eta"))
      bsdf.eta = 2.0 / (1.0 - std::sqrt(0.08 * object.get<double>("specular"))) - 1.0;
    // An index of 1 does not refract; at 1.0011, a third of a millionth is reflected at normal incidence.
    if (object.given("specular") && !object.given("eta"))
      bsdf.eta.value = std::max(bsdf.eta.value, 1.0 + 1.1 * kMinIndexContrast);
    return bsdf;
  }

  /// Whether an object has a parameter that has a meaning only as a texture.
  bool has_map(const Object& object, const char* name) {
    if (object.child_of(name) != nullptr) return true;
    if (object.given(name))
      sink_.error(object.position_of(name), fmt::format("\"{}\" is a map; give it a <texture>", name));
    return false;
  }

  GltfBsdf read_gltf(const Object& object, Scene* scene) {
    auto bsdf = read_parameters<GltfBsdf>(object, scene);
    bsdf.anisotropy_rotation = glm::radians(object.get<double>("anisotropy_rotation"));
    bsdf.thin = object.get<bool>("thin");
    bsdf.dispersion = object.get<double>("dispersion");
    bsdf.coat_keeps_normal = object.get<bool>("coat_keeps_normal");
    bsdf.coat_vertex_tangents = object.get<bool>("coat_vertex_tangents");
    if (has_map(object, "coat_normals")) bsdf.coat_normals = read_factor(object, "coat_normals", scene);
    if (has_map(object, "anisotropy_directions"))
      bsdf.anisotropy_directions = read_factor(object, "anisotropy_directions", scene);
    bsdf.attenuation_color = object.get<glm::dvec3>("attenuation_color");
    const auto distance = object.get<double>("attenuation_distance");
    if (distance > 0.0) bsdf.attenuation_distance = distance;
    if (bsdf.thin && object.given("attenuation_distance"))
      sink_.error(object.position_of("attenuation_distance"),
                  "a thin sheet has no inside where light could travel a distance; give \"thin\" the value false");
    return bsdf;
  }

  MicrofacetBsdf read_microfacet(const Object& object, Scene* scene) {
    return {.kd = read_factor(object, "kd", scene),
            .alpha = read_scalar(object, "alpha", scene),
            .int_ior = object.get<double>("intIOR"),
            .ext_ior = object.get<double>("extIOR")};
  }

  ConductorIndex read_metal(const Object& object, Scene* scene) {
    if (object.given("eta") != object.given("k")) {
      sink_.error(object.position_of(object.given("eta") ? "eta" : "k"),
                  "a complex index of refraction has two parts; give both \"eta\" and \"k\"");
    }
    if (object.given("material") && (object.given("eta") || object.given("k"))) {
      sink_.error(object.position_of("material"),
                  "the metal has both a material and an index of refraction; remove one of them");
    }
    if (!object.given("material")) return {read_factor(object, "eta", scene), read_factor(object, "k", scene)};
    const auto name = object.get<std::string>("material");
    const auto index = metal_index(text::trim(name));
    if (!index) {
      sink_.error(object.position_of("material"),
                  fmt::format("there is no material {}{}; known are {}", text::quoted(name),
                              text::did_you_mean(name, metal_names()), text::join(metal_names())));
    }
    return index.value_or(ConductorIndex{});
  }

  template <typename Plastic>
  Plastic read_plastic(const Object& object, Scene* scene) {
    Plastic plastic;
    plastic.diffuse_reflectance = read_factor(object, "diffuse_reflectance", scene);
    plastic.specular_reflectance = read_factor(object, "specular_reflectance", scene);
    plastic.int_ior = object.get<double>("intIOR");
    plastic.ext_ior = object.get<double>("extIOR");
    plastic.nonlinear = object.get<bool>("nonlinear");
    return plastic;
  }

  Roughness::Distribution read_distribution(const Object& object) {
    const auto name = object.get<std::string>("distribution");
    if (text::trim(name) == "ggx") return Roughness::Distribution::ggx;
    if (text::trim(name) != "beckmann") {
      sink_.error(object.position_of("distribution"),
                  fmt::format("there is no distribution {}; use beckmann or ggx", text::quoted(name)));
    }
    return Roughness::Distribution::beckmann;
  }

  Roughness read_roughness(const Object& object, Scene* scene) {
    Roughness roughness{.distribution = read_distribution(object)};
    const ScalarParameter alpha = read_scalar(object, "alpha", scene);
    roughness.alpha_u = object.given("alpha_u") ? read_scalar(object, "alpha_u", scene) : alpha;
    roughness.alpha_v = object.given("alpha_v") ? read_scalar(object, "alpha_v", scene) : alpha;
    if (object.given("alpha") && (object.given("alpha_u") || object.given("alpha_v"))) {
      sink_.error(object.position_of("alpha"),
                  "the roughness is given twice; use alpha for both directions, or alpha_u and alpha_v");
    }
    return roughness;
  }

  /// A colour, or the texture in its place.
  ColorParameter read_factor(const Object& object, const char* property, Scene* scene) {
    if (object.child_of(property) != nullptr) return read_textured(object, property, scene);
    return object.get<glm::dvec3>(property);
  }

  /// A colour given by a texture.
  ColorParameter read_textured(const Object& object, const char* property, Scene* scene) {
    remember_fields(object, {property});
    const XmlElement* element = object.child_of(property);
    if (context_.approximate && element != nullptr && is_unknown(*element)) {
      context_.approximated(fmt::format("texture {}", element->find("type")->value), "grey, 0.5",
                            context_.document.position(element->offset));
      return glm::dvec3(0.5);
    }
    const std::optional<std::uint32_t> texture = textures_.read(object, property, *scene);
    if (const std::optional<glm::dvec3> constant = textures_.constant(object, property)) return *constant;
    return texture ? ColorParameter(textures_.factor(object, property), *texture) : ColorParameter(glm::dvec3(1.0));
  }

  /// Courses place the picture of the sky on a large sphere, and look it up by direction.
  std::optional<Instance> read_sky_mesh(const Object& emitter, Scene& scene) {
    sink_.warning(
        emitter.position(),
        "the picture on a mesh is read as light from all around the scene, infinitely far away; the mesh is left out");
    add_environment(emitter, *scene_object_, scene, true);
    return std::nullopt;
  }

  /// Emitters of the scene itself: lights without extent, and light from all around.
  void read_lights(const Object& scene_object, Scene& scene) {
    scene_object_ = &scene_object;
    has_environment_ = false;
    for (const XmlElement* element : scene_object.children("emitter")) {
      const auto object = Object::read(*element, context_);
      if (!object) continue;
      if (is_delta_light(object->plugin().type)) {
        const auto textured = [&](const Object& owner, const char* name) { return read_textured(owner, name, &scene); };
        scene.delta_lights.push_back(read_delta_light(*object, textured, sink_));
        remember_field(*object, "toWorld", "world_from_light");
        for (const char* name : {"intensity", "irradiance", "radiance", "power"}) {
          if (object->plugin().find(name) != nullptr) remember_field(*object, name, "intensity");
        }
        continue;
      }
      add_environment(*object, scene_object, scene, false);
    }
    read_scene_sky(scene_object, scene);
  }

  /// A picture of the sky that is a property of the scene.
  void read_scene_sky(const Object& scene_object, Scene& scene) {
    if (!scene_object.given("envmap")) return;
    if (has_environment_ || scene_object.given("sky_top") || scene_object.given("sky_horizon")) {
      sink_.error(scene_object.position_of("envmap"), "\"envmap\" and another sky are two; keep one of them");
      return;
    }
    has_environment_ = true;
    if (scene_object.get<double>("envmapScale") == 0.0) return;
    const std::string filename(text::trim(scene_object.get<std::string>("envmap")));
    scene.sky.picture = load_sky(filename, scene_object.position_of("envmap"),
                                 {.bitmap = nullptr, .scale = scene_object.get<double>("envmapScale")});
    const SourcePosition where = scene.position;
    fields_[{where.line, where.column, "sky_picture"}] = scene_object.position_of("envmap");
    fields_[{where.line, where.column, "sky_scale"}] = scene_object.position_of("envmapScale");
  }

  void add_environment(const Object& object, const Object& scene_object, Scene& scene, bool in_mesh) {
    if (has_environment_)
      sink_.error(object.position(),
                  fmt::format("{} is a second emitter of light from all around the scene; keep one of them",
                              object.plugin().type));
    has_environment_ = true;
    read_environment(object, scene_object, scene);
    if (std::string_view(object.plugin().type) == "envmap" && scene.sky.picture) raise_sky(object, in_mesh, scene);
  }

  /// Why a picture of the sky has its upper edge toward +Z; "" if nothing says so.
  static std::string reason_for_z_up(const glm::dmat3& turn, bool in_mesh, const Camera& camera) {
    constexpr double kNearly = 0.999;
    const glm::dvec3 z = glm::normalize(turn[2]);
    const glm::dvec3 up = glm::normalize(glm::dvec3(camera.world_from_camera[1]));
    if (in_mesh) return "the picture is in a mesh";
    if (z.y > kNearly) return "toWorld turns +Z to +Y";
    // Nobody wants the horizon upright.
    if (z.z > kNearly && up.z > std::abs(up.x) && up.z > std::abs(up.y)) return "the camera has +Z up";
    return "";
  }

  /// Pictures whose upper edge is toward +Z, as courses have them.
  void raise_sky(const Object& object, bool in_mesh, Scene& scene) {
    const auto up = object.get<std::string>("up");
    if (!up.empty() && up != "y" && up != "z") {
      sink_.error(object.position_of("up"),
                  fmt::format("{} is no axis toward the upper edge of the picture; use y or z", text::quoted(up)));
      return;
    }
    const glm::dmat3 turn(object.matrix("toWorld"));
    const std::string reason = reason_for_z_up(turn, in_mesh, scene.camera);
    if (up == "y" || (up.empty() && reason.empty())) return;
    if (up.empty())
      sink_.note(object.position(),
                 reason + ": the upper edge of the picture is read as its +Z; set \"up\" to y if it is not");
    scene.sky.world_from_sky = turn * glm::dmat3(0, 1, 0, 0, 0, 1, -1, 0, 0);
  }

  /// Light from outside: an emitter of the scene itself.
  void read_environment(const Object& object, const Object& scene_object, Scene& scene) {
    const std::string_view type = object.plugin().type;
    if (type == "area") {
      return sink_.error(
          object.position(),
          "an area light belongs in the mesh that emits; light from all around the scene is constant or envmap");
    }
    for (const char* name : {"sky_top", "sky_horizon"}) {
      if (scene_object.given(name)) {
        sink_.error(scene_object.position_of(name),
                    fmt::format("\"{}\" and an emitter of the scene are two skies; remove one of them", name));
      }
    }
    if (type == "constant") {
      scene.sky.top = scene.sky.horizon = object.get<glm::dvec3>("radiance");
      return;
    }
    if (is_daylight(type)) {
      scene.sky.picture = SkyPicture{.bitmap = make_daylight(read_daylight(object, sink_))};
    } else {
      read_sky(object, scene);
    }
    scene.sky.world_from_sky = glm::dmat3(object.matrix("toWorld"));
    const auto place = [&](const char* field, const char* property) {
      fields_[{scene.position.line, scene.position.column, field}] = object.position_of(property);
    };
    if (!is_daylight(type)) {
      place("sky_picture", object.child_of("radiance") != nullptr ? "radiance" : "filename");
      place("sky_scale", "scale");
    }
    place("world_from_sky", "toWorld");
  }

  /// A picture, which courses also give by a texture; or, without one, a colour.
  void read_sky(const Object& object, Scene& scene) {
    const XmlElement* const child = object.child_of("radiance");
    const std::optional<Object> texture = child != nullptr ? Object::read(*child, context_) : std::nullopt;
    if (child != nullptr && !texture) return;
    if (texture && object.given("filename"))
      return sink_.error(object.position_of("filename"),
                         "the sky has two pictures, this one and that of its texture; keep one");
    const std::string_view type = texture ? std::string_view(texture->plugin().type) : "";
    if (texture && type != "bitmap" && type != "constant_color")
      return sink_.error(texture->position(), fmt::format("a {} is no picture of a sky; use a bitmap", type));
    const bool uniform = texture ? type == "constant_color" : object.given("radiance") && !object.given("filename");
    const auto scale = object.get<double>("scale");
    if (uniform) {
      const auto radiance = texture ? texture->get<glm::dvec3>("value") : object.get<glm::dvec3>("radiance");
      scene.sky.top = scene.sky.horizon = scale * radiance;
      return;
    }
    glm::dvec3 factor(1.0);
    if (!texture)
      factor = object.get<glm::dvec3>("radiance");
    else if (texture->given("scale"))
      factor = texture->get<glm::dvec3>("scale");
    if (factor.x != factor.y || factor.y != factor.z)
      return sink_.error(object.position_of("radiance"),
                         "a picture of a sky takes a grey factor; tint the picture itself");
    if (!(factor.x > 0.0))
      return sink_.error(object.position_of("radiance"),
                         "the factor of a sky must be above 0; remove the emitter for a black sky");
    scene.sky.picture = read_sky_picture(object, texture ? *texture : object);
    if (scene.sky.picture) scene.sky.picture->scale = scale * factor.x;
  }

  /// `owner` names the file: the emitter, or its texture.
  std::optional<SkyPicture> read_sky_picture(const Object& object, const Object& owner) {
    SkyPicture picture{.bitmap = nullptr, .scale = object.get<double>("scale")};
    const auto rows = object.get<std::string>("rows");
    if (rows == "circles") {
      picture.rows = SkyPicture::Rows::circles;
    } else if (rows != "bands") {
      const std::vector<std::string> known = {"bands", "circles"};
      sink_.error(object.position_of("rows"), fmt::format("{} is not a kind of rows{}; known are bands and circles",
                                                          text::quoted(rows), text::did_you_mean(rows, known)));
    }
    if (!owner.given("filename")) {
      sink_.error(owner.position(), fmt::format("<{} type=\"{}\"> needs its property \"filename\"; add <string "
                                                "name=\"filename\" …/>",
                                                owner.plugin().tag, owner.plugin().type));
      return std::nullopt;
    }
    return load_sky(std::string(text::trim(owner.get<std::string>("filename"))), owner.position_of("filename"),
                    std::move(picture));
  }

  std::optional<SkyPicture> load_sky(const std::string& filename, const SourcePosition& position, SkyPicture picture) {
    if (filename.empty()) {
      sink_.error(position, "the name is empty; give the path of a picture");
      return std::nullopt;
    }
    const fs::path path = files_.find(filename, "picture", position);
    if (path.empty()) return std::nullopt;
    try {
      Bitmap bitmap = read_bitmap(path.string());
      for (const std::string& note : bitmap.notes) sink_.note(position, note);
      if (const std::size_t count = clear_negative_values(bitmap); count > 0) {
        sink_.warning(position, fmt::format("the picture {} has {} negative values; they are taken as 0",
                                            text::quoted(path.filename().string()), count));
      }
      picture.bitmap = std::make_shared<const Bitmap>(std::move(bitmap));
    } catch (const Error& error) {
      sink_.error(position, fmt::format("picture {}{}", error.what(), files_.remedy(filename, path)), error.kind());
      return std::nullopt;
    }
    return picture;
  }

  AreaEmitter read_emitter(const Object& object, Scene& scene) {
    if (std::string_view(object.plugin().type) != "area") {
      const char* what =
          is_delta_light(object.plugin().type) ? "a light of its own" : "light from all around the scene";
      sink_.error(object.position(), fmt::format("{} is {}, not of a mesh; move it into <scene>, or use area",
                                                 object.plugin().type, what));
      return {};
    }
    const auto scale = object.get<double>("scale");
    const bool two_sided = object.get<bool>("two_sided");
    if (object.child_of("radiance") != nullptr) {
      ColorParameter textured = read_textured(object, "radiance", &scene);
      textured.value *= scale;
      return {textured, object.position(), two_sided};
    }
    const glm::dvec3 radiance = scale * object.get<glm::dvec3>("radiance");
    remember_fields(object, {"radiance"});
    if (object.given("radiance") && radiance == glm::dvec3(0.0)) {
      sink_.warning(object.position_of("radiance"), "radiance 0 0 0: this emitter sends no light");
    }
    return {radiance, object.position(), two_sided};
  }

  std::optional<TriangleMesh> read_mesh(const Object& object, const MeshFormat& format, const MeshContent& content,
                                        std::string& name) {
    const auto text = object.get<std::string>("filename");
    const std::string filename(text::trim(text));
    if (!object.given("filename")) return std::nullopt;
    const SourcePosition position = object.position_of("filename");
    if (filename.empty()) {
      sink_.error(position, fmt::format("\"filename\" is empty; give the path of an {} file", format.title));
      return std::nullopt;
    }
    const fs::path path = files_.find(filename, "mesh", position);
    name = path.filename().string();
    if (path.empty() || sink_.error_count() >= kMaxErrorsBeforeMeshes) return std::nullopt;
    return load_mesh(format, filename, path, content, position);
  }

  std::optional<TriangleMesh> load_mesh(const MeshFormat& format, const std::string& filename, const fs::path& path,
                                        const MeshContent& content, const SourcePosition& position) {
    if (too_many_meshes_) return std::nullopt;
    std::error_code unknown;
    const std::uintmax_t bytes = fs::file_size(path, unknown);
    if (!unknown) mesh_bytes_ += bytes;
    if (exceeds(mesh_bytes_, kMaxMeshBytes, "bytes of mesh files", position)) return std::nullopt;
    std::optional<TriangleMesh> mesh;
    try {
      mesh = load_mesh_(format, path.string(), content, sink_);
    } catch (const Error& error) {  // the file cannot be opened or read: say which object names it
      sink_.error(position, fmt::format("mesh {}{}", error.what(), files_.remedy(filename, path)), error.kind());
    }
    if (!mesh) return std::nullopt;
    triangles_ += mesh->triangles.size();
    vertices_ += mesh->positions.size();
    if (exceeds(triangles_, kMaxTriangles, "triangles", position)) return std::nullopt;
    if (exceeds(vertices_, kMaxVertices, "vertices", position)) return std::nullopt;
    return mesh;
  }

  /// Reports a sum over all meshes that is too large, once; no further mesh is read then.
  bool exceeds(std::uintmax_t sum, std::uintmax_t limit, const char* what, const SourcePosition& position) {
    if (sum <= limit) return false;
    too_many_meshes_ = true;
    sink_.error(position,
                fmt::format("with this mesh the scene has {} {}; at most {} are supported: use coarser meshes", sum,
                            what, limit));
    return true;
  }

  /// The place on a test's patch whose texture coordinates are these.
  glm::dvec2 read_patch_place(const Object& test) {
    const auto uv = test.get<std::vector<double>>("uv");
    if (uv.size() == 2) return {uv[0], uv[1]};
    sink_.error(test.position_of("uv"), fmt::format("\"uv\" has {} numbers; give two, u and v", uv.size()));
    return {};
  }

  std::vector<TestBsdf> read_test_bsdfs(const Object& test) {
    std::vector<TestBsdf> bsdfs;
    const glm::dvec2 uv = read_patch_place(test);
    for (const XmlElement* element : test.children("bsdf")) {
      const auto object = Object::read(*element, context_);
      if (!object) continue;
      Scene patch;
      patch.file = path_;
      patch.position = object->position();
      materials_.clear();
      textures_.begin_scene();
      material_row(*element, patch);
      add_test_patch(patch, uv);
      check_scene(patch);
      bsdfs.push_back(
          {std::move(patch), fmt::format("{} {}", object->plugin().type, bsdfs.size() + 1), object->position()});
    }
    return bsdfs;
  }

  std::vector<double> read_angles(const Object& object) {
    std::vector<double> angles = object.get<std::vector<double>>("angles");
    if (std::ranges::find(angles, 90.0) != angles.end())
      sink_.error(object.position_of("angles"),
                  "an angle is 90: light along the surface meets neither side; leave it out");
    return angles;
  }

  TTest read_ttest(const Object& object) {
    TTest test;
    in_test_ = true;
    test.significance_level = object.get<double>("significanceLevel");
    test.sample_count = static_cast<std::uint64_t>(object.get<std::int64_t>("sampleCount"));
    test.references = object.get<std::vector<double>>("references");
    test.angles = read_angles(object);
    const std::string stem = fs::path(path_).stem().string();
    const std::vector<const XmlElement*> scenes = object.children("scene");
    const std::size_t bsdf_count = object.children("bsdf").size();
    for (const XmlElement* element : scenes) {
      if (const auto scene = Object::read(*element, context_))
        test.scenes.push_back(read_scene(*scene, fmt::format("{}[{}]", stem, test.scenes.size() + 1)));
    }
    test.bsdfs = read_test_bsdfs(object);
    check_ttest(test, object, scenes.size(), bsdf_count);
    return test;
  }

  void check_ttest(const TTest& test, const Object& object, std::size_t scene_count, std::size_t bsdf_count) {
    if (scene_count == 0 && bsdf_count == 0) {
      sink_.error(object.position(), "the test has neither <scene> nor <bsdf> children; add what is to be tested");
      return;
    }
    if (scene_count > 0 && bsdf_count > 0) {
      sink_.error(object.position(),
                  fmt::format("the test mixes {} scenes and {} bsdfs; write two test files", scene_count, bsdf_count));
      return;
    }
    if (bsdf_count > 0 && test.angles.empty()) {
      if (!object.given("angles"))
        sink_.error(object.position(),
                    "a test of bsdfs needs its property \"angles\"; add <string name=\"angles\" value=\"0, 30, 60\"/>");
      else
        sink_.error(object.position_of("angles"), "\"angles\" is empty; give angles of incidence in degrees");
      return;
    }
    if (scene_count > 0 && object.given("angles"))
      sink_.warning(object.position_of("angles"), "\"angles\" has no effect on scenes");
    const std::size_t expected = scene_count > 0 ? scene_count : bsdf_count * test.angles.size();
    if (!object.given("references") || test.references.size() == expected) return;
    const std::string children =
        scene_count > 0 ? fmt::format("{} scenes", scene_count)
                        : fmt::format("{} bsdfs × {} angles = {} results", bsdf_count, test.angles.size(), expected);
    sink_.error(object.position_of("references"),
                fmt::format("{} references for {}; each needs exactly one", test.references.size(), children));
  }

  Chi2Test read_chi2test(const Object& object) {
    Chi2Test test;
    test.significance_level = object.get<double>("significanceLevel");
    test.resolution = to_uint32(object.get<std::int64_t>("resolution"));
    test.min_exp_frequency = object.get<double>("minExpFrequency");
    test.sample_count = static_cast<std::uint64_t>(object.get<std::int64_t>("sampleCount"));
    test.test_count = to_uint32(object.get<std::int64_t>("testCount"));
    test.angles = read_angles(object);
    test.bsdfs = read_test_bsdfs(object);
    return test;
  }

  struct Field {
    int line, column;  ///< of the object's tag
    std::string name;  ///< in scene.h
    auto operator<=>(const Field&) const = default;
  };
  struct LoadedMesh {
    std::uint32_t shape;
    std::string name;
  };
  struct EmptyMesh {
    SourcePosition position;
    std::string name;
  };

  ReadContext& context_;
  Diagnostics& sink_;
  std::map<Field, SourcePosition> fields_;
  std::map<const XmlElement*, std::uint32_t>
      materials_;                             ///< rows of the <bsdf> elements of the scene that is being read
  std::map<std::string, LoadedMesh> meshes_;  ///< of the scene that is being read, by file and how it is read
  std::map<const XmlElement*, std::vector<Instance>> groups_;  ///< of that scene, in their own space
  const MeshLoader& load_mesh_;
  std::string path_;
  NamedFiles files_;
  TextureReader textures_;
  std::size_t triangles_ = 0, vertices_ = 0;
  std::uintmax_t mesh_bytes_ = 0;
  bool too_many_meshes_ = false;
  bool in_test_ = false;
  const Object* scene_object_ = nullptr;  ///< of the scene that is being read
  bool has_environment_ = false;          ///< that scene
  std::vector<EmptyMesh> empty_meshes_;   ///< of the scene that is being read
};

void report_unmatched_overrides(const ReadContext& context) {
  const std::vector<std::string> known(context.overridable.begin(), context.overridable.end());
  for (std::size_t i = 0; i < context.overrides.size(); ++i) {
    if (context.override_matched[i]) continue;
    const auto& [name, value] = context.overrides[i];
    context.diagnostics.error({fmt::format("-D {}={}", name, value), 0, 0},
                              fmt::format("{} has no property {}{}; known here are: {}", context.document.file(),
                                          text::quoted(name), text::did_you_mean(name, known), text::join(known)),
                              ErrorKind::usage);
  }
}

}  // namespace

std::optional<SceneFile> parse_scene_file(std::string text, const std::string& file, const ReadOptions& options,
                                          const MeshLoader& load_mesh, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  const XmlDocument document(std::move(text), file, diagnostics);
  std::optional<SceneFile> result = read_nori(document, options, load_mesh, diagnostics);
  return diagnostics.error_count() > errors_before ? std::nullopt : std::move(result);
}

std::optional<SceneFile> read_nori(const XmlDocument& document, const ReadOptions& options, const MeshLoader& load_mesh,
                                   Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  if (!document.root()) return std::nullopt;
  const Dialect& dialect = nori_dialect();
  const std::size_t errors_before_references = diagnostics.error_count();
  const References references(document, dialect, diagnostics);
  // Following wrong ones might not terminate.
  if (diagnostics.error_count() > errors_before_references) return std::nullopt;
  ReadContext context{
      dialect,           document,       references, diagnostics,
      options.overrides, options.strict, {},         std::vector<bool>(options.overrides.size(), false)};
  context.approximate = options.approximate;
  context.shows_uv = options.shows_uv;
  std::optional<SceneFile> result = SceneReader(context, load_mesh).read(*document.root());
  if (auto* scene = result ? std::get_if<Scene>(&*result) : nullptr) scene->approximations = context.approximations;
  report_lacking(context);
  // After other errors, the object of the override may be missing.
  if (diagnostics.error_count() == errors_before) report_unmatched_overrides(context);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return result;
}

}  // namespace etendue
