#include "formats/mitsuba/mitsuba_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>

#include "core/text.h"
#include "formats/mitsuba/mitsuba_shapes.h"
#include "formats/mitsuba/plugins.h"
#include "scene/invariants.h"

namespace etendue {
namespace {

namespace fs = std::filesystem;

/// Paths in a set of the sampler that stands for all of Mitsuba's well-spread ones: 2^4.
constexpr std::uint32_t kSetBits = 4;

/// Turns the objects of a document into a Scene. Every function reports what is wrong and goes on with something
/// usable, so that one pass finds all problems.
class MitsubaReader {
 public:
  MitsubaReader(const MitsubaContext& context, const MitsubaFiles& files, Scene& scene)
      : context_(context), scene_(scene), materials_(context, scene), shapes_(context, files, materials_, scene) {}

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
  }

 private:
  /// The object of a tag of which one counts; nothing if it is missing or unusable.
  std::optional<MitsubaObject> only_child(const MitsubaObject& parent, const char* tag, const char* substitute) {
    const std::vector<const XmlElement*> children = parent.children(tag);
    if (children.empty()) return std::nullopt;
    return MitsubaObject::read(*children.front(), context_, substitute);
  }

  void read_integrator(const MitsubaObject& root) {
    std::optional<MitsubaObject> object = only_child(root, "integrator", "path");
    // What wraps another one, at most a few deep: a reference may lead back to where it stands.
    for (int depth = 0; object && (object->type() == "moment" || object->type() == "aov"); ++depth) {
      constexpr int kMaxWrappers = 8;
      if (depth == kMaxWrappers) {
        context_.sink.error(object->position(), fmt::format("integrators lie {} deep within each other", depth));
        return;
      }
      object = only_child(*object, "integrator", "path");
    }
    if (!object) object = MitsubaObject::defaulted("integrator", "path", root.position(), context_);
    const bool direct = object->type() == "direct";
    if (!direct && object->type() != "path")
      context_.sink.note(object->position(), fmt::format("the integrator {} is taken as path, which computes the same "
                                                         "light",
                                                         object->type()));
    direct ? read_direct(*object) : read_path(*object);
    scene_.integrator.hide_emitters = object->boolean("hide_emitters");
  }

  void read_path(const MitsubaObject& object) {
    Integrator& integrator = scene_.integrator;
    const std::int64_t depth = object.integer("max_depth");
    integrator.max_depth = depth < 0 ? Integrator::kUnlimitedDepth : static_cast<std::uint32_t>(depth);
    integrator.rr_depth = static_cast<std::uint32_t>(object.integer("rr_depth"));
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

  void read_sensor(const MitsubaObject& root) {
    const std::vector<const XmlElement*> sensors = root.children("sensor");
    if (sensors.empty()) return;  // reported
    if (sensors.size() > 1)
      context_.sink.note(context_.document.position(*sensors[1]),
                         fmt::format("the scene has {} sensors; the first one is rendered", sensors.size()));
    std::optional<MitsubaObject> sensor = MitsubaObject::read(*sensors.front(), context_, "perspective, 40 degrees");
    if (!sensor) return;
    Camera& camera = scene_.camera;
    camera.position = sensor->position();
    read_film(*sensor, camera);
    camera.fov = horizontal_fov(*sensor, camera);
    camera.near_clip = sensor->real("near_clip");
    camera.far_clip = sensor->real("far_clip");
    camera.world_from_camera = sensor->matrix("to_world");
    for (const char* name : {"principal_point_offset_x", "principal_point_offset_y"}) {
      if (sensor->real(name) != 0.0) context_.missing.add(name, sensor->position_of(name), "0");
    }
    read_sampler(*sensor);
  }

  void read_film(const MitsubaObject& sensor, Camera& camera) {
    std::optional<MitsubaObject> film = only_child(sensor, "film", "hdrfilm");
    if (!film) film = MitsubaObject::defaulted("film", "hdrfilm", sensor.position(), context_);
    camera.width = static_cast<std::uint32_t>(film->integer("width"));
    camera.height = static_cast<std::uint32_t>(film->integer("height"));
    const auto crops = [&](const char* name, std::int64_t whole) {
      if (film->given(name) && film->integer(name) != whole)
        context_.missing.add("crop of a film", film->position_of(name), "the whole film");
    };
    crops("crop_offset_x", 0);
    crops("crop_offset_y", 0);
    crops("crop_width", camera.width);
    crops("crop_height", camera.height);
    camera.filter = read_filter(*film);
  }

  ReconstructionFilter read_filter(const MitsubaObject& film) {
    using Type = ReconstructionFilter::Type;
    std::optional<MitsubaObject> object = only_child(film, "rfilter", "gaussian");
    if (!object) object = MitsubaObject::defaulted("rfilter", "gaussian", film.position(), context_);
    const std::string_view type = object->type();
    if (type == "box") return {.type = Type::box};
    if (type == "tent") {
      if (object->real("radius") != 1.0)
        context_.missing.add("tent filter of another radius", object->position_of("radius"), "radius 1");
      return {.type = Type::tent};
    }
    if (type == "catmullrom") return {.type = Type::mitchell, .radius = 2.0, .b = 0.0, .c = 0.5};
    if (type == "mitchell") {
      const bool by_letter = object->given("C");  // B and C of the paper; else A and B of Mitsuba
      return {.type = Type::mitchell,
              .radius = 2.0,
              .b = object->real(by_letter ? "B" : "A"),
              .c = object->real(by_letter ? "C" : "B")};
    }
    const double stddev = object->real("stddev");
    return {.type = Type::gaussian, .radius = 4.0 * stddev, .stddev = stddev};
  }

  /// Degrees. A focal length is that of a lens in front of a 35 mm film, whose diagonal counts.
  double horizontal_fov(const MitsubaObject& sensor, const Camera& camera) {
    constexpr double kDegrees = 180.0 / std::numbers::pi;
    const double w = camera.width, h = camera.height;
    std::string axis = sensor.text("fov_axis");
    double fov = 0.0;
    if (sensor.given("fov")) {
      fov = sensor.real("fov");
      if (fov <= 0.0) fov = 40.0;  // reported
    } else {
      fov = 2.0 * kDegrees * std::atan(std::hypot(36.0, 24.0) / (2.0 * focal_length(sensor)));
      axis = "diagonal";
    }
    if (axis == "smaller") axis = w > h ? "y" : "x";
    if (axis == "larger") axis = w > h ? "x" : "y";
    const double tangent = std::tan(0.5 * fov / kDegrees);
    if (axis == "x") return fov;
    if (axis == "y") return 2.0 * kDegrees * std::atan(tangent * w / h);
    if (axis == "diagonal") return 2.0 * kDegrees * std::atan(tangent * w / std::hypot(w, h));
    const std::vector<std::string> known = {"x", "y", "diagonal", "smaller", "larger"};
    context_.sink.error(sensor.position_of("fov_axis"),
                        fmt::format("{} is no axis of the film{}; known are: {}", text::quoted(axis),
                                    text::did_you_mean(axis, known), text::join(known)));
    return fov;
  }

  /// Millimetres.
  double focal_length(const MitsubaObject& sensor) {
    std::string word = sensor.text("focal_length");
    if (word.ends_with("mm")) word.resize(word.size() - 2);
    double length = 0.0;
    if (text::parse_double(text::trim(word), length) == text::NumberError::none && length > 0.0) return length;
    context_.sink.error(sensor.position_of("focal_length"),
                        fmt::format("{} is no focal length; write for example 50mm", text::quoted(word)));
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
                       fmt::format("the sampler {} is taken as sobol, in sets of {}", object->type(), 1u << kSetBits));
  }

  void read_emitter(const XmlElement& element) {
    // An area light beside the shapes is there to be referred to.
    const XmlAttribute* type = element.find("type");
    if (type != nullptr && type->value == "area" && element.find("id") != nullptr) return;
    const auto emitter = MitsubaObject::read(element, context_, "left out");
    if (!emitter) return;
    if (emitter->type() != "constant")
      return context_.sink.error(emitter->position(), "an emitter area belongs into the <shape> that emits");
    const glm::dvec3 radiance = materials_.constant(emitter->color("radiance", SpectrumUse::emission));
    if (has_sky_)
      return context_.sink.error(emitter->position(),
                                 "the scene has more than one emitter of the surroundings; keep one");
    has_sky_ = true;
    scene_.sky.top = scene_.sky.horizon = radiance;
  }

  const MitsubaContext& context_;
  Scene& scene_;
  MitsubaMaterials materials_;
  MitsubaShapes shapes_;
  bool has_sky_ = false;
};

}  // namespace

std::optional<Scene> parse_mitsuba_scene(std::unique_ptr<XmlDocument> document, const ReadOptions& options,
                                         const MitsubaFiles& files, Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  const MitsubaDocument mitsuba(std::move(document), options, files.text, diagnostics);
  MissingFeatures missing(options.approximate);
  Scene scene;
  // After other errors a file may be missing that defines what the rest refers to.
  if (diagnostics.error_count() == errors_before) {
    const MitsubaContext context{mitsuba, mitsuba_dialect(), diagnostics, missing, options.strict};
    MitsubaReader(context, files, scene).read();
    missing.report(mitsuba.position(mitsuba.root()), diagnostics);
  }
  if (diagnostics.error_count() == errors_before) check_invariants(scene, diagnostics);
  if (diagnostics.error_count() > errors_before) return std::nullopt;
  return scene;
}

}  // namespace etendue
