#include "formats/mitsuba/mitsuba_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/printable.h"
#include "core/text.h"
#include "formats/camera_option.h"
#include "formats/mitsuba/mitsuba_daylight.h"
#include "formats/mitsuba/mitsuba_distant.h"
#include "formats/mitsuba/mitsuba_lights.h"
#include "formats/mitsuba/mitsuba_shapes.h"
#include "formats/mitsuba/plugins.h"
#include "scene/bounds.h"
#include "scene/invariants.h"
#include "scene/similarity.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

/// The sampler that replaces all of Mitsuba's stratified ones has sets of 2^4 paths.
constexpr std::uint32_t kSetBits = 4;
/// Meters see everything, but a ray that starts on a surface must not hit that surface. In camera units.
constexpr double kMeterNearClip = 1e-5, kMeterFarClip = 1e10;

std::optional<Aov> mitsuba_aov(std::string_view word) {
  if (word == "sh_normal") return Aov::shading_normal;
  if (word == "geo_normal") return Aov::geometric_normal;
  if (word == "prim_index") return Aov::primitive;
  if (word == "shape_index") return Aov::instance;
  if (word == "depth" || word == "position" || word == "uv" || word == "albedo") return aov_named(word);
  return std::nullopt;
}

/// Turns the objects of a document into a Scene. Every function reports what is wrong and continues with something
/// usable, so that one pass finds all problems.
class MitsubaReader {
 public:
  MitsubaReader(const MitsubaContext& context, const MitsubaFiles& files, Scene& scene)
      : context_(context),
        scene_(scene),
        textures_(context, files, scene),
        materials_(context, textures_, scene),
        shapes_(context, files, materials_, textures_, scene) {}

  void read() {
    const MitsubaDocument& document = context_.document;
    scene_.name = fs::path(document.file()).stem().string();
    scene_.file = document.file();
    const auto root = MitsubaObject::read(document.root(), context_, "");
    if (!root) return;
    scene_.position = root->position();
    read_integrator(*root);
    read_sensor(*root);
    for (const XmlElement* emitter : root->children("emitter")) read_emitter(*emitter);
    for (const XmlElement* shape : root->children("shape")) shapes_.add(*shape);
    shapes_.finish();
    set_automatic_length();
    if (distant_) set_distant_camera(*distant_, bounds_of(scene_), context_, scene_.camera);
  }

 private:
  /// The only child with a tag; nothing if it is missing or unusable.
  std::optional<MitsubaObject> only_child(const MitsubaObject& parent, const char* tag, const char* substitute) {
    const std::vector<const XmlElement*> children = parent.children(tag);
    if (children.empty()) return std::nullopt;
    return MitsubaObject::read(*children.front(), context_, substitute);
  }

  void read_integrator(const MitsubaObject& root) {
    std::optional<MitsubaObject> object = only_child(root, "integrator", "path");
    // Integrators that wrap another one. The depth is limited, because references may be circular.
    for (int depth = 0; object && (object->type() == "moment" || object->type() == "aov"); ++depth) {
      constexpr int kMaxWrappers = 8;
      if (depth == kMaxWrappers) {
        context_.sink.error(object->position(), fmt::format("integrators are nested {} deep", depth));
        return;
      }
      if (object->type() == "aov") read_aovs(*object);
      object = only_child(*object, "integrator", "path");
    }
    if (!object) object = MitsubaObject::defaulted("integrator", "path", root.position(), context_);
    if (object->type() == "ao") return read_occlusion(*object);
    if (object->type() == "depth") return void(scene_.integrator.type = Integrator::Type::distance);
    const bool direct = object->type() == "direct";
    if (!direct && object->type() != "path")
      context_.sink.note(
          object->position(),
          fmt::format("the integrator {} is read as path, which computes the same light", object->type()));
    direct ? read_direct(*object) : read_path(*object);
    scene_.integrator.hide_emitters = object->boolean("hide_emitters");
  }

  /// Reads "name:kind,…". The names are ignored, because channels have fixed names here.
  void read_aovs(const MitsubaObject& object) {
    const std::string list = object.text("aovs");
    for (std::size_t start = 0; start < list.size();) {
      const std::size_t end = std::min(list.find(',', start), list.size());
      const std::size_t colon = std::min(list.find(':', start), end);
      const std::string word = colon < end ? list.substr(colon + 1, end - colon - 1) : "";
      if (const std::optional<Aov> aov = mitsuba_aov(word)) {
        scene_.aovs.push_back(*aov);
      } else {
        context_.missing.add(fmt::format("aov {}", text::printable(list.substr(start, end - start), 40)),
                             object.position_of("aovs"), "left out");
      }
      start = end + 1;
    }
  }

  void read_path(const MitsubaObject& object) {
    Integrator& integrator = scene_.integrator;
    const std::int64_t depth = object.integer("max_depth");
    integrator.max_depth = depth < 0 ? Integrator::kUnlimitedDepth : static_cast<std::uint32_t>(depth);
    integrator.rr_depth = static_cast<std::uint32_t>(object.integer("rr_depth"));
    integrator.count_passes = object.type().find("vol") == std::string_view::npos;
    if (depth != 0) return;
    context_.sink.error(object.position_of("max_depth"), "max_depth 0 leaves no light at all; use 1 or more, or -1");
    integrator.max_depth = 1;
  }

  void read_direct(const MitsubaObject& object) {
    Integrator& integrator = scene_.integrator;
    integrator.type = Integrator::Type::direct;
    const auto samples = [&](const char* name) {
      return static_cast<std::uint32_t>(object.integer(object.given(name) ? name : "shading_samples"));
    };
    integrator.emitter_samples = samples("emitter_samples");
    integrator.bsdf_samples = samples("bsdf_samples");
    if (integrator.emitter_samples + integrator.bsdf_samples == 0)
      context_.sink.error(object.position(), "the integrator samples neither lights nor materials; let it do one");
  }

  /// The length may have to wait until the shapes are known.
  void read_occlusion(const MitsubaObject& object) {
    scene_.integrator.type = Integrator::Type::ambient_occlusion;
    const double length = object.real("ray_length");
    if (length > 0.0) scene_.integrator.length = length;
    automatic_length_ = !(length > 0.0);
  }

  /// As in Mitsuba 0.6, half the radius of the sphere around the box of all shapes.
  void set_automatic_length() {
    if (!automatic_length_ || scene_.instances.empty() || context_.sink.has_errors()) return;
    const Bounds bounds = bounds_of(scene_);
    scene_.integrator.length = 0.25 * glm::distance(bounds.min, bounds.max);
  }

  void read_sensor(const MitsubaObject& root) {
    const std::vector<const XmlElement*> sensors = root.children("sensor");
    if (sensors.empty()) return read_meter_of_shape(root);
    if (sensors.size() > 1)
      context_.sink.note(context_.document.position(*sensors[1]),
                         fmt::format("the scene has {} sensors; the first one is rendered", sensors.size()));
    std::optional<MitsubaObject> sensor = MitsubaObject::read(*sensors.front(), context_, "perspective, 40 degrees");
    if (!sensor) return;
    const MitsubaObject held = *sensor;  // has the film
    if (sensor->type() == "batch") sensor = first_of_batch(held);
    if (!sensor) return;
    if (sensor->given("srf"))
      context_.missing.add("a sensor's response to wavelengths (srf)", sensor->position_of("srf"), "left out");
    if (sensor->plugin().find("jitter") != nullptr && !sensor->boolean("jitter"))
      context_.missing.add("a sensor without jitter", sensor->position_of("jitter"),
                           "rays are spread over their pixels");
    if (sensor->type() == "irradiancemeter")
      return context_.sink.error(sensor->position(), "an irradiancemeter belongs in the <shape> that light falls on");
    Camera& camera = scene_.camera;
    camera.position = sensor->position();
    read_film(held, camera);
    if (held.type() == "batch")
      camera.width = std::max(camera.width / static_cast<std::uint32_t>(held.children("sensor").size()), 1u);
    if (sensor->type() == "distant") return read_distant(*sensor);
    camera.type = camera_type(sensor->type());
    if (sensor->plugin().find("fov") != nullptr) read_field_of_view(*sensor, camera);
    if (sensor->plugin().find("aperture_radius") != nullptr) read_aperture(*sensor, camera);
    camera.near_clip = sensor->real("near_clip");
    camera.far_clip = sensor->real("far_clip");
    camera.world_from_camera = sensor->matrix("to_world");
    if (camera.type == Camera::Type::radiance_meter) read_meter(*sensor, camera);
    read_sampler(held);
  }

  /// The first of several sensors that share a film side by side.
  std::optional<MitsubaObject> first_of_batch(const MitsubaObject& batch) {
    const std::vector<const XmlElement*> sensors = batch.children("sensor");
    if (sensors.empty()) return std::nullopt;  // has been reported
    context_.missing.add("sensor batch", batch.position(), "the first of its sensors, with its share of the film");
    std::optional<MitsubaObject> first = MitsubaObject::read(*sensors.front(), context_, "perspective, 40 degrees");
    if (!first || first->type() != "batch") return first;
    context_.sink.error(first->position(), "a batch of sensors holds no other batch");
    return std::nullopt;
  }

  /// The sensor's position has to wait until the shapes are known.
  void read_distant(const MitsubaObject& sensor) {
    const Camera& camera = scene_.camera;
    if (camera.width != 1 || camera.height != 1)
      context_.sink.error(sensor.position(), fmt::format("a sensor distant measures one number, and its film has {} by "
                                                         "{} pixels; give it a <film> of 1 by 1",
                                                         camera.width, camera.height));
    distant_ = sensor;
    read_sampler(sensor);
  }

  /// An irradiance meter is a child of the shape whose light it measures.
  void read_meter_of_shape(const MitsubaObject& root) {
    for (const XmlElement* element : root.children("shape")) {
      const auto is_sensor = [&](const XmlElement& child) {
        return context_.dialect.canonical(child.name) == "sensor";
      };
      if (std::ranges::none_of(element->children, is_sensor)) continue;
      const auto shape = MitsubaObject::read(*element, context_, "left out");
      if (!shape) return;
      const auto sensor = MitsubaObject::read(*shape->children("sensor").front(), context_, "left out");
      if (!sensor) return;
      if (sensor->type() != "irradiancemeter" || shape->type() != "rectangle")
        return context_.missing.add(fmt::format("{} on a {}", sensor->type(), shape->type()), sensor->position(),
                                    "an irradiancemeter at the origin");
      Camera& camera = scene_.camera;
      camera.position = sensor->position();
      camera.type = Camera::Type::irradiance_meter;
      camera.world_from_camera = shape->matrix("to_world");
      if (shape->boolean("flip_normals"))
        for (const int axis : {0, 2}) camera.world_from_camera[axis] = -camera.world_from_camera[axis];
      camera.near_clip = kMeterNearClip;
      camera.far_clip = kMeterFarClip;
      read_film(*sensor, camera);
      return read_sampler(*sensor);
    }
    if (!context_.camera_given)
      return context_.sink.error(root.position(), "<scene> needs a <sensor>; add one, or place a camera by --camera");
    const MitsubaObject sensor = MitsubaObject::defaulted("sensor", "perspective", root.position(), context_);
    read_film(sensor, scene_.camera);
    read_field_of_view(sensor, scene_.camera);
    read_sampler(sensor);
  }

  static Camera::Type camera_type(std::string_view type) {
    using enum Camera::Type;
    if (type == "perspective") return perspective;
    if (type == "thinlens") return thin_lens;
    if (type == "orthographic") return orthographic;
    if (type == "spherical") return spherical;
    if (type == "radiancemeter") return radiance_meter;
    throw std::logic_error(fmt::format("the reader has no sensor {}", type));
  }

  void read_aperture(const MitsubaObject& sensor, Camera& camera) {
    camera.aperture.radius = sensor.real("aperture_radius");
    camera.aperture.focus_distance =
        sensor.given("focus_distance") ? sensor.real("focus_distance") : sensor.real("far_clip");
    if (camera.aperture.radius > 0.0) return;
    context_.sink.note(sensor.position_of("aperture_radius"), "a lens of radius 0 is a pinhole");
    camera.type = Camera::Type::perspective;
    camera.aperture = {};
  }

  /// A meter's position and direction may be given without a transform.
  void read_meter(const MitsubaObject& sensor, Camera& camera) {
    if (!sensor.given("near_clip")) camera.near_clip = kMeterNearClip;
    if (!sensor.given("far_clip")) camera.far_clip = kMeterFarClip;
    if (!sensor.given("origin") && !sensor.given("direction")) return;
    const glm::dvec3 direction = sensor.triple("direction");
    if (!(glm::length(direction) > 0.0))
      return context_.sink.error(sensor.position_of("direction"), "the direction has length 0; give another one");
    const glm::dvec3 z = glm::normalize(direction);
    const glm::dvec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0), z));
    camera.world_from_camera = {glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0), glm::dvec4(z, 0),
                                glm::dvec4(sensor.triple("origin"), 1)};
  }

  /// The crop window becomes the film, which remembers its place in the whole picture.
  void read_film(const MitsubaObject& sensor, Camera& camera) {
    std::optional<MitsubaObject> film = only_child(sensor, "film", "hdrfilm");
    if (!film) film = MitsubaObject::defaulted("film", "hdrfilm", sensor.position(), context_);
    const auto part = [&](const char* whole_name, const char* offset_name, const char* size_name, double& origin,
                          double& share) {
      const std::int64_t whole = film->integer(whole_name), offset = film->integer(offset_name);
      std::int64_t size = film->given(size_name) ? film->integer(size_name) : whole - offset;
      if (size < 1 || offset + size > whole) {
        const char* wrong = film->given(size_name) ? size_name : offset_name;
        context_.sink.error(film->position_of(wrong),
                            fmt::format("{} pixels from pixel {} on do not fit into a film of {}",
                                        std::max<std::int64_t>(size, 1), offset, whole));
        size = whole;
      }
      origin = static_cast<double>(offset) / static_cast<double>(whole);
      share = static_cast<double>(size) / static_cast<double>(whole);
      return static_cast<std::uint32_t>(size);
    };
    camera.width = part("width", "crop_offset_x", "crop_width", camera.window.origin.x, camera.window.size.x);
    camera.height = part("height", "crop_offset_y", "crop_height", camera.window.origin.y, camera.window.size.y);
    camera.filter = read_filter(*film);
  }

  ReconstructionFilter read_filter(const MitsubaObject& film) {
    using Type = ReconstructionFilter::Type;
    std::optional<MitsubaObject> object = only_child(film, "rfilter", "gaussian");
    if (!object) object = MitsubaObject::defaulted("rfilter", "gaussian", film.position(), context_);
    const std::string_view type = object->type();
    if (type == "box") return {.type = Type::box, .stretch = object->real("radius") / 0.5};
    if (type == "tent") return {.type = Type::tent, .stretch = object->real("radius")};
    if (type == "lanczos")
      return {.type = Type::lanczos, .lobes = static_cast<std::uint32_t>(object->integer("lobes"))};
    if (type == "catmullrom") return {.type = Type::mitchell, .radius = 2.0, .b = 0.0, .c = 0.5};
    if (type == "mitchell") {
      const bool by_letter = object->given("C");  // B and C as in the paper, otherwise Mitsuba's A and B
      return {.type = Type::mitchell,
              .radius = 2.0,
              .b = object->real(by_letter ? "B" : "A"),
              .c = object->real(by_letter ? "C" : "B")};
    }
    const double stddev = object->real("stddev");
    return {.type = Type::gaussian, .radius = 4.0 * stddev, .stddev = stddev};
  }

  /// A focal length refers to 35 mm film, and to the diagonal.
  void read_field_of_view(const MitsubaObject& sensor, Camera& camera) {
    camera.window.principal_offset = {sensor.real("principal_point_offset_x"), sensor.real("principal_point_offset_y")};
    camera.fov_axis = fov_axis(sensor);
    if (sensor.given("fov")) {
      camera.fov = sensor.real("fov");
      if (camera.fov <= 0.0) camera.fov = 40.0;  // reported
      return;
    }
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    camera.fov = 2.0 * kDegrees * std::atan(std::hypot(36.0, 24.0) / (2.0 * focal_length(sensor)));
    camera.fov_axis = Camera::FovAxis::diagonal;
  }

  Camera::FovAxis fov_axis(const MitsubaObject& sensor) {
    using enum Camera::FovAxis;
    const std::string axis = sensor.text("fov_axis");
    if (axis == "x") return x;
    if (axis == "y") return y;
    if (axis == "diagonal") return diagonal;
    if (axis == "smaller") return smaller;
    if (axis == "larger") return larger;
    const std::vector<std::string> known = {"x", "y", "diagonal", "smaller", "larger"};
    context_.sink.error(sensor.position_of("fov_axis"),
                        fmt::format("{} is not an axis of the film{}; known are: {}", text::quoted(axis),
                                    text::did_you_mean(axis, known), text::join(known)));
    return x;
  }

  /// In millimetres.
  double focal_length(const MitsubaObject& sensor) {
    std::string word = sensor.text("focal_length");
    if (word.ends_with("mm")) word.resize(word.size() - 2);
    double length = 0.0;
    if (text::parse_double(text::trim(word), length) == text::NumberError::none && length > 0.0) return length;
    context_.sink.error(sensor.position_of("focal_length"),
                        fmt::format("{} is not a focal length; write for example 50mm", text::quoted(word)));
    return 50.0;
  }

  void read_sampler(const MitsubaObject& sensor) {
    std::optional<MitsubaObject> object = only_child(sensor, "sampler", "independent");
    if (!object) object = MitsubaObject::defaulted("sampler", "independent", sensor.position(), context_);
    scene_.sampler.sample_count = static_cast<std::uint32_t>(object->integer("sample_count"));
    if (object->type() == "independent") return;
    scene_.sampler.type = Sampler::Type::sobol;
    scene_.sampler.set_bits = kSetBits;
    context_.sink.note(object->position(),
                       fmt::format("the sampler {} is read as sobol, in sets of {}", object->type(), 1u << kSetBits));
  }

  void read_emitter(const XmlElement& element) {
    // An area light outside of shapes is there to be referred to.
    const XmlAttribute* type = element.find("type");
    if (type != nullptr && type->value == "area" && element.find("id") != nullptr) return;
    const auto emitter = MitsubaObject::read(element, context_, "left out");
    if (!emitter) return;
    const std::string_view kind = emitter->type();
    if (is_mitsuba_delta_light(kind)) {
      scene_.delta_lights.push_back(read_mitsuba_delta_light(*emitter, textures_, scene_, context_));
      return;
    }
    if (kind == "area")
      return context_.sink.error(emitter->position(), "an emitter area belongs in the <shape> that emits");
    if (std::exchange(has_sky_, true))
      return context_.sink.error(emitter->position(),
                                 "the scene has more than one emitter of the surroundings; keep one");
    if (is_mitsuba_daylight(kind)) {
      if (const auto sky = read_mitsuba_daylight(*emitter, context_)) scene_.sky = *sky;
      return;
    }
    kind == "envmap" ? read_environment(*emitter) : read_constant(*emitter);
  }

  void read_constant(const MitsubaObject& emitter) {
    const glm::dvec3 radiance =
        textures_.constant(emitter.color("radiance", SpectrumUse::emission), "radiance of constant");
    scene_.sky.top = scene_.sky.horizon = radiance;
  }

  /// The emitter's picture, named by itself or by a bitmap in it.
  std::shared_ptr<const Bitmap> picture_of(const MitsubaObject& emitter) {
    const std::vector<const XmlElement*> within = emitter.children("texture");
    if (within.empty() == !emitter.given("filename")) {
      context_.sink.error(emitter.position(), within.empty()
                                                  ? "an envmap needs its picture; add <string name=\"filename\" …/>"
                                                  : "the envmap has both \"filename\" and a texture; keep one of them");
      return nullptr;
    }
    if (within.empty()) return textures_.picture(emitter);
    const auto texture = MitsubaObject::read(*within.front(), context_, "left out");
    if (!texture) return nullptr;
    if (texture->type() != "bitmap") {
      context_.missing.add(fmt::format("texture {} of an envmap", texture->type()), texture->position(), "left out");
      return nullptr;
    }
    for (const char* moved : {"to_uv", "uvscale", "uscale", "vscale", "uoffset", "voffset"}) {
      if (texture->given(moved))
        context_.missing.add("an envmap whose bitmap is moved", texture->position_of(moved), "as it is");
    }
    std::shared_ptr<const Bitmap> bitmap = textures_.picture(*texture);
    if (bitmap == nullptr || !texture->boolean("raw") || bitmap->color_space == ColorSpace::linear) return bitmap;
    auto raw = std::make_shared<Bitmap>(*bitmap);
    raw->color_space = ColorSpace::linear;
    return raw;
  }

  void read_environment(const MitsubaObject& emitter) {
    const std::shared_ptr<const Bitmap> bitmap = picture_of(emitter);
    if (bitmap == nullptr) return;
    scene_.sky.picture = {
        .bitmap = without_negative(bitmap, emitter), .scale = emitter.real("scale"), .rows = SkyPicture::Rows::circles};
    scene_.sky.world_from_sky = glm::dmat3(emitter.matrix("to_world", RotationAxes::unit));
  }

  std::shared_ptr<const Bitmap> without_negative(const std::shared_ptr<const Bitmap>& bitmap,
                                                 const MitsubaObject& emitter) {
    auto cleared = std::make_shared<Bitmap>(*bitmap);
    const std::size_t count = clear_negative_values(*cleared);
    if (count == 0) return bitmap;
    context_.sink.warning(emitter.position_of("filename"),
                          fmt::format("the picture has {} negative values; they are taken as 0", count));
    return cleared;
  }

  const MitsubaContext& context_;
  Scene& scene_;
  MitsubaTextures textures_;
  MitsubaMaterials materials_;
  MitsubaShapes shapes_;
  std::optional<MitsubaObject> distant_;
  bool has_sky_ = false;
  bool automatic_length_ = false;
};

}  // namespace

std::optional<Scene> parse_mitsuba_scene(std::unique_ptr<XmlDocument> document, const ReadOptions& options,
                                         const MitsubaFiles& files, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  const MitsubaDocument mitsuba(std::move(document), options, files.text, diagnostics);
  MissingFeatures missing(options.approximate);
  Scene scene;
  // After an error, an included file may be missing that defines what the rest refers to.
  if (diagnostics.error_count() == errors_before) {
    const MitsubaContext context{mitsuba,    mitsuba_dialect(), diagnostics,      missing,
                                 files.text, options.strict,    options.shows_uv, is_camera_placement(options.camera)};
    MitsubaReader(context, files, scene).read();
    missing.report(mitsuba.position(mitsuba.root()), diagnostics);
    if (options.approximate) scene.approximations = missing.substitutes();
  }
  round_to_similarities(scene);
  if (diagnostics.error_count() == errors_before) check_invariants(scene, diagnostics);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return scene;
}

}  // namespace etendue
