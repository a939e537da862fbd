#include "formats/nori/nori_writer.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/dialect/material_writer.h"

namespace etendue {
namespace {

class NoriWriter : MaterialWriter {
 public:
  NoriWriter(const std::string& path, const Scene& scene)
      : MaterialWriter(path, scene,
                       {.color = "color",
                        .albedo = "albedo",
                        .mirror = "mirror",
                        .blend = "blend",
                        .int_ior = "intIOR",
                        .ext_ior = "extIOR",
                        .lacking = "which a scene file cannot say"}) {}

  void write(ExistingFiles existing) {
    xml_.open("scene");
    if (scene_.instancing != Instancing::automatic)
      xml_.text("instancing", scene_.instancing == Instancing::never ? "never" : "always");
    write_sky();
    for (const DeltaLight& light : scene_.delta_lights) write_delta_light(light);
    write_integrator(scene_.integrator);
    write_sampler(scene_.sampler);
    write_camera(scene_.camera);
    write_materials();
    for (const Instance& instance : scene_.instances) write_instance(instance);
    xml_.close();
    files_.write(xml_.result(), existing);
  }

  std::string camera_alone() {
    write_camera(scene_.camera);
    return xml_.elements();
  }
  using MaterialWriter::material_alone;

 private:
  void write_sky() {
    const Sky& sky = scene_.sky;
    if (!sky.picture) {
      if (sky.top == glm::dvec3(0.0) && sky.horizon == glm::dvec3(0.0)) return;
      if (sky.world_from_sky != glm::dmat3(1.0)) refuse("the sky is a gradient that is turned");
      color("sky_top", sky.top);
      color("sky_horizon", sky.horizon);
      return;
    }
    xml_.open("emitter", {{"type", "envmap"}});
    xml_.text("filename", files_.picture(sky.picture->bitmap));
    xml_.number("scale", sky.picture->scale);
    if (sky.picture->rows == SkyPicture::Rows::circles) xml_.text("rows", "circles");
    xml_.text("up", "y");
    xml_.transform("toWorld", glm::dmat4(sky.world_from_sky));
    xml_.close();
  }

  void write_delta_light(const DeltaLight& light) {
    using Type = DeltaLight::Type;
    constexpr const char* kTypes[] = {"point", "spot", "projector", "directional"};
    constexpr const char* kFalloffs[] = {"linear", "smooth", "quartic"};
    constexpr double kDegrees = 57.295779513082320877;
    xml_.open("emitter", {{"type", kTypes[static_cast<std::size_t>(light.type)]}});
    const bool plane = light.type == Type::projector || light.type == Type::directional;
    color(plane ? "irradiance" : "intensity", light.intensity);
    if (light.type == Type::spot) {
      xml_.number("cutoffAngle", light.cutoff);
      xml_.number("beamWidth", light.beam_width);
      xml_.text("falloff", kFalloffs[static_cast<std::size_t>(light.falloff)]);
    }
    if (light.type == Type::projector) {
      xml_.number("fov", 2.0 * std::atan(light.slope.x) * kDegrees);
      xml_.number("aspect", light.slope.x / light.slope.y);
    }
    xml_.transform("toWorld", light.world_from_light);
    xml_.close();
  }

  void write_integrator(const Integrator& integrator) {
    using enum Integrator::Type;
    switch (integrator.type) {
      case path:
        xml_.open("integrator", {{"type", "path"}});
        xml_.integer("maxDepth", integrator.max_depth);
        xml_.integer("rrDepth", integrator.rr_depth);
        xml_.boolean("nee", integrator.nee);
        if (integrator.nee) xml_.boolean("mis", integrator.mis);
        if (!integrator.count_passes) xml_.boolean("countPasses", false);
        break;
      case normals:
      case absolute_normals:
        xml_.open("integrator", {{"type", "normals"}});
        xml_.boolean("signed", integrator.type == normals);
        break;
      case direct:
        xml_.open("integrator", {{"type", "direct"}});
        xml_.integer("emitterSamples", integrator.emitter_samples);
        xml_.integer("bsdfSamples", integrator.bsdf_samples);
        break;
      case whitted:
        xml_.open("integrator", {{"type", "whitted"}});
        break;
      case simple:
        xml_.open("integrator", {{"type", "simple"}});
        xml_.property("point", "position", shortest(integrator.light.position));
        color("energy", integrator.light.energy);
        break;
      case ambient_occlusion:
      case visibility:
        xml_.open("integrator", {{"type", integrator.type == visibility ? "av" : "ao"}});
        if (std::isfinite(integrator.length)) xml_.number("length", integrator.length);
        break;
      case depth:
      case distance:
        xml_.open("integrator", {{"type", integrator.type == depth ? "depth" : "distance"}});
        break;
      case aov:
        throw Error(ErrorKind::scene, fmt::format("the integrator renders nothing but the AOV {}, which no scene file "
                                                  "asks for",
                                                  traits(integrator.aov).name));
    }
    if (gathers_light(integrator)) {
      using enum Integrator::LightSampler;
      if (integrator.hide_emitters) xml_.boolean("hideEmitters", true);
      if (integrator.hide_background) xml_.boolean("hideBackground", true);
      if (integrator.light_sampler != automatic)
        xml_.text("lightSampler", integrator.light_sampler == power ? "power" : "tree");
    }
    if (!scene_.aovs.empty()) xml_.text("aovs", to_text(scene_.aovs));
    xml_.close();
  }

  void write_sampler(const Sampler& sampler) {
    const bool sobol = sampler.type == Sampler::Type::sobol;
    xml_.open("sampler", {{"type", sobol ? "sobol" : "independent"}});
    xml_.integer("sampleCount", sampler.sample_count);
    if (sobol) xml_.integer("setSize", sampler.set_size());
    xml_.close();
  }

  const char* word_of(Camera::Type type) const {
    using enum Camera::Type;
    switch (type) {
      case perspective:
        return "perspective";
      case thin_lens:
        return "thinlens";
      case orthographic:
        return "orthographic";
      case spherical:
        return "spherical";
      case radiance_meter:
        return "radiancemeter";
      case irradiance_meter:
        return "irradiancemeter";
    }
    throw std::logic_error("a camera of no type");
  }

  void write_camera(const Camera& camera) {
    using enum Camera::Type;
    xml_.open("camera", {{"type", word_of(camera.type)}});
    write_film(camera);
    if (camera.type == perspective || camera.type == thin_lens) {
      constexpr const char* kAxes[] = {"x", "y", "diagonal", "smaller", "larger"};
      xml_.number("fov", camera.fov);
      if (camera.fov_axis != Camera::FovAxis::x) xml_.text("fovAxis", kAxes[static_cast<std::size_t>(camera.fov_axis)]);
      if (camera.window.principal_offset.x != 0.0)
        xml_.number("principalPointOffsetX", camera.window.principal_offset.x);
      if (camera.window.principal_offset.y != 0.0)
        xml_.number("principalPointOffsetY", camera.window.principal_offset.y);
    }
    if (camera.type == thin_lens) {
      xml_.number("apertureRadius", camera.aperture.radius);
      xml_.number("focusDistance", camera.aperture.focus_distance);
      xml_.integer("blades", camera.aperture.blades);
      xml_.number("bladeRotation", camera.aperture.rotation);
    }
    xml_.number("nearClip", camera.near_clip);
    xml_.number("farClip", camera.far_clip);
    if (camera.path.empty()) xml_.transform("toWorld", camera.world_from_camera);
    write_path(camera.path);
    write_filter(camera.filter);
    xml_.close();
  }

  void write_path(const CameraPath& path) {
    if (path.curve == CameraPath::Curve::linear) xml_.text("path", "linear");
    for (const CameraKey& key : path.keys) {
      xml_.open("keyframe");
      xml_.number("time", key.time);
      xml_.transform("toWorld", key.world_from_camera);
      xml_.close();
    }
  }

  /// A film that is a part of a larger one came from whole numbers of pixels, which are recovered.
  void write_film(const Camera& camera) {
    const FilmWindow& window = camera.window;
    const auto whole = [](std::uint32_t pixels, double share) {
      return static_cast<std::int64_t>(std::llround(static_cast<double>(pixels) / share));
    };
    const std::int64_t width = whole(camera.width, window.size.x), height = whole(camera.height, window.size.y);
    const std::int64_t x = std::llround(window.origin.x * static_cast<double>(width));
    const std::int64_t y = std::llround(window.origin.y * static_cast<double>(height));
    const glm::dvec2 size = glm::dvec2(camera.width, camera.height) / glm::dvec2(width, height);
    const glm::dvec2 origin = glm::dvec2(x, y) / glm::dvec2(width, height);
    if (size != window.size || origin != window.origin)
      refuse("the film is a part of another that is not whole pixels");
    xml_.integer("width", width);
    xml_.integer("height", height);
    if (size == glm::dvec2(1.0) && origin == glm::dvec2(0.0)) return;
    xml_.integer("cropOffsetX", x);
    xml_.integer("cropOffsetY", y);
    xml_.integer("cropWidth", camera.width);
    xml_.integer("cropHeight", camera.height);
  }

  void write_filter(const ReconstructionFilter& filter) {
    using enum ReconstructionFilter::Type;
    switch (filter.type) {
      case box:
        if (filter.stretch == 1.0) return xml_.leaf("rfilter", {{"type", "box"}});
        xml_.open("rfilter", {{"type", "box"}});
        xml_.number("radius", 0.5 * filter.stretch);
        break;
      case tent:
        if (filter.stretch == 1.0) return xml_.leaf("rfilter", {{"type", "tent"}});
        xml_.open("rfilter", {{"type", "tent"}});
        xml_.number("radius", filter.stretch);
        break;
      case lanczos:
        xml_.open("rfilter", {{"type", "lanczos"}});
        xml_.integer("lobes", filter.lobes);
        break;
      case gaussian:
        xml_.open("rfilter", {{"type", "gaussian"}});
        xml_.number("radius", filter.radius);
        xml_.number("stddev", filter.stddev);
        break;
      case mitchell:
        xml_.open("rfilter", {{"type", "mitchell"}});
        xml_.number("radius", filter.radius);
        xml_.number("B", filter.b);
        xml_.number("C", filter.c);
        break;
    }
    xml_.close();
  }

  /// The texture of a property: written with an id at its first use, and referred to by that later. A texture
  /// multiplied by several colours is written once for each.
  void write_texture(const char* name, std::uint32_t row, const glm::dvec3& factor,
                     std::optional<TextureChannel> of_number) override {
    const TextureChannel channel = of_number.value_or(TextureChannel::luminance);
    const std::string id = fmt::format("texture-{}", textures_.size());
    const auto [known, is_new] = textures_.try_emplace({row, factor.x, factor.y, factor.z, channel}, id);
    if (!is_new) return xml_.leaf("ref", {{"name", name}, {"id", known->second}});
    const Texture& texture = scene_.textures[row];
    require_first_set(texture);
    std::visit([&](const auto& source) { write_source(name, id, source); }, texture.source);
    if (factor != glm::dvec3(1.0)) color("scale", factor);
    if (texture.vertex_tint) xml_.boolean("vertex_tint", true);
    if (texture.alpha_cutoff) xml_.number("alpha_cutoff", *texture.alpha_cutoff);
    if (texture.premultiplied) xml_.boolean("premultiplied", true);
    constexpr const char* kChannels[] = {"red", "green", "blue", "alpha", "luminance"};
    if (channel != TextureChannel::luminance) xml_.text("channel", kChannels[static_cast<std::size_t>(channel)]);
    const glm::dmat3& m = texture.uv_transform;
    if (!std::holds_alternative<AttributeTexture>(texture.source))
      xml_.transform("to_uv", {m[0][0], m[0][1], 0, 0, m[1][0], m[1][1], 0, 0, 0, 0, 1, 0, m[2][0], m[2][1], 0, 1});
    xml_.close();
  }
  void write_source(const char* name, const std::string& id, const BitmapTexture& source) {
    constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};
    const std::shared_ptr<const Bitmap>& bitmap = scene_.bitmaps[source.bitmap];
    const bool linear = source.color_space.value_or(bitmap->color_space) == ColorSpace::linear;
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "bitmap"}});
    xml_.text("filename", files_.picture(bitmap));
    if (linear && bitmap->color_space == ColorSpace::srgb) xml_.boolean("raw", true);
    if (!linear && bitmap->color_space == ColorSpace::linear)
      refuse("a picture with linear numbers is decoded from sRGB");
    if (source.wrap_u != source.wrap_v) refuse("a texture is wrapped differently along u and v");
    xml_.text("wrap_mode", kWraps[static_cast<std::size_t>(source.wrap_u)]);
    if (source.filter == TextureFilter::nearest) xml_.text("filter_type", "nearest");
  }
  void write_source(const char* name, const std::string& id, const CheckerboardTexture& source) {
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "checkerboard"}});
    color("color0", square(source.color0, source.texture0));
    color("color1", square(source.color1, source.texture1));
  }
  void write_source(const char* name, const std::string& id, const AttributeTexture& source) {
    const bool faces = source.source == AttributeTexture::Source::face_color;
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "mesh_attribute"}});
    xml_.text("attribute", faces ? "face_color" : "vertex_color");
  }

  void write_vertex_tangents() override { xml_.boolean("vertex_tangents", true); }

  void write_microfacet(const std::string& id, const MicrofacetBsdf& bsdf) override {
    open_bsdf(id, "microfacet");
    color("kd", bsdf.kd);
    number("alpha", bsdf.alpha);
    write_indices(bsdf);
  }

  void write_gltf(const std::string& id, const GltfBsdf& bsdf) override {
    constexpr double kDegrees = 57.295779513082320877;
    open_bsdf(id, "gltf");
    write_parameters(bsdf);
    if (bsdf.coat_keeps_normal) xml_.boolean("coat_keeps_normal", true);
    if (bsdf.coat_normals.texture && bsdf.coat_vertex_tangents) xml_.boolean("coat_vertex_tangents", true);
    if (bsdf.dispersion != 0.0) number("dispersion", bsdf.dispersion);
    if (bsdf.anisotropy_rotation != 0.0) number("anisotropy_rotation", bsdf.anisotropy_rotation * kDegrees);
    xml_.boolean("thin", bsdf.thin);
    if (!std::isfinite(bsdf.attenuation_distance)) return;
    color("attenuation_color", bsdf.attenuation_color);
    number("attenuation_distance", bsdf.attenuation_distance);
  }

  void write_instance(const Instance& instance) {
    std::visit([&](const auto& shape) { write_shape(instance, shape); }, scene_.shape_of(instance));
    xml_.transform("toWorld", instance.world_from_object);
    if (instance.flip_normals) xml_.boolean("flipNormals", true);
    refer_to(instance.material);
    if (const AreaEmitter* emitter = scene_.emitter_of(instance)) {
      xml_.open("emitter", {{"type", "area"}});
      color("radiance", emitter->radiance);
      if (emitter->two_sided) xml_.boolean("two_sided", true);
      xml_.close();
    }
    xml_.close();
  }
  void write_shape(const Instance& instance, const TriangleMesh&) {
    xml_.open("mesh", {{"type", "ply"}});
    xml_.text("filename", files_.mesh(instance.shape, uv_set_of(instance)));
  }
  void write_shape(const Instance&, const Sphere& sphere) {
    xml_.open("mesh", {{"type", "sphere"}});
    xml_.property("point", "center", shortest(sphere.center));
    xml_.number("radius", sphere.radius);
  }
  void write_shape(const Instance&, const Disk&) { xml_.open("mesh", {{"type", "disk"}}); }
  void write_shape(const Instance&, const Cylinder& cylinder) {
    xml_.open("mesh", {{"type", "cylinder"}});
    xml_.property("point", "p0", shortest(cylinder.p0));
    xml_.property("point", "p1", shortest(cylinder.p1));
    xml_.number("radius", cylinder.radius);
  }

  std::map<std::tuple<std::uint32_t, double, double, double, TextureChannel>, std::string>
      textures_;  ///< ids by row, factor and channel
};

}  // namespace

void write_scene(const std::string& path, const Scene& scene, ExistingFiles existing) {
  NoriWriter(path, scene).write(existing);
}

std::string camera_element(const Camera& camera) {
  Scene scene;
  scene.camera = camera;
  return NoriWriter("the camera", scene).camera_alone();
}

std::string bsdf_element(const Scene& scene, std::uint32_t row) {
  return NoriWriter("the material", scene).material_alone(row);
}

}  // namespace etendue
