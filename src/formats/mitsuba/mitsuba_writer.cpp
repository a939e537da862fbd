#include "formats/mitsuba/mitsuba_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/dialect/material_writer.h"
#include "formats/mitsuba/mitsuba_textures.h"
#include "scene/limits.h"
#include "scene/materials.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

bool is_mirrored(const glm::dmat4& m) {
  return glm::determinant(glm::dmat3(m)) < 0.0;
}

/// A linear picture of floats.
std::shared_ptr<Bitmap> float_bitmap(std::uint32_t width, std::uint32_t height) {
  auto bitmap = std::make_shared<Bitmap>();
  bitmap->width = width;
  bitmap->height = height;
  bitmap->channels = 3;
  bitmap->format = BitmapFormat::f32;
  bitmap->texels.resize(bitmap->row_bytes() * height);
  return bitmap;
}
void set_texel(Bitmap& bitmap, std::uint32_t x, std::uint32_t y, const glm::vec3& color) {
  std::memcpy(&bitmap.texels[y * bitmap.row_bytes() + x * sizeof color], &color, sizeof color);
}

class MitsubaWriter : MaterialWriter {
 public:
  MitsubaWriter(const std::string& path, const Scene& scene)
      : MaterialWriter(path, scene,
                       {.color = "rgb",
                        .albedo = "reflectance",
                        .mirror = "conductor",
                        .blend = "blendbsdf",
                        .int_ior = "int_ior",
                        .ext_ior = "ext_ior",
                        .lacking = "which Mitsuba does not have"}) {}

  void write(ExistingFiles existing) {
    xml_.open("scene", {{"version", "3.0.0"}});
    write_integrators();
    write_sensor(scene_.camera);
    write_sky();
    for (const DeltaLight& light : scene_.delta_lights) write_delta_light(light);
    write_materials();
    note_masks();
    for (const Instance& instance : scene_.instances) write_shape(instance);
    xml_.close();
    files_.write(xml_.result(), existing);
  }
  std::string sensor_alone() {
    write_sensor(scene_.camera);
    return xml_.elements();
  }
  using MaterialWriter::material_alone;
  const std::vector<std::string>& differences() const { return differences_; }

 private:
  void differs(std::string sentence) { differences_.push_back(std::move(sentence)); }

  void write_delta_light(const DeltaLight& light) {
    using Type = DeltaLight::Type;
    constexpr const char* kTypes[] = {"point", "spot", "projector", "directional"};
    constexpr double kDegrees = 57.295779513082320877;
    xml_.open("emitter", {{"type", kTypes[static_cast<std::size_t>(light.type)]}});
    const bool plane = light.type == Type::projector || light.type == Type::directional;
    const bool picture = light.type == Type::spot && light.intensity.texture;
    if (picture) {
      color("intensity", light.intensity.value);
      color("texture", ColorParameter(glm::dvec3(1.0), *light.intensity.texture));
    } else {
      color(plane ? "irradiance" : "intensity", light.intensity);
    }
    if (light.type == Type::spot) {
      number("cutoff_angle", light.cutoff);
      number("beam_width", light.beam_width);
      if (light.falloff != DeltaLight::Falloff::linear) differs("a spot fades linearly with the angle");
    }
    if (light.type == Type::projector) {
      number("scale", 1.0 / std::numbers::pi);  // see mitsuba_lights.cpp
      number("fov", 2.0 * std::atan(light.slope.x) * kDegrees);
    }
    xml_.transform("to_world", light.world_from_light);
    xml_.close();
  }

  /// Mitsuba's word for an AOV; null if it has none.
  static const char* mitsuba_word(Aov aov) {
    switch (aov) {
      case Aov::depth:
      case Aov::position:
      case Aov::uv:
      case Aov::albedo:
        return traits(aov).name;
      case Aov::shading_normal:
        return "sh_normal";
      case Aov::geometric_normal:
        return "geo_normal";
      case Aov::instance:
        return "shape_index";
      case Aov::primitive:
        return "prim_index";
      default:
        return nullptr;
    }
  }

  /// Writes the integrator, wrapped in Mitsuba's `aov` if there are AOVs for it.
  void write_integrators() {
    std::string list;
    for (const Aov aov : scene_.aovs) {
      const char* word = mitsuba_word(aov);
      if (word == nullptr) differs(fmt::format("Mitsuba has no AOV {}", traits(aov).name));
      if (word != nullptr) list += fmt::format("{}{}:{}", list.empty() ? "" : ",", traits(aov).name, word);
    }
    if (!list.empty()) {
      xml_.open("integrator", {{"type", "aov"}});
      xml_.text("aovs", list);
    }
    write_integrator(scene_.integrator);
    if (!list.empty()) xml_.close();
  }

  void write_integrator(const Integrator& integrator) {
    using enum Integrator::Type;
    if (integrator.type == direct) {
      xml_.open("integrator", {{"type", "direct"}});
      xml_.integer("emitter_samples", integrator.emitter_samples);
      xml_.integer("bsdf_samples", integrator.bsdf_samples);
    } else if (integrator.type == path) {
      constexpr std::int64_t kNever = 1 << 30;
      xml_.open("integrator", {{"type", "path"}});
      xml_.integer("max_depth",
                   integrator.max_depth >= Integrator::kUnlimitedDepth ? -1 : std::int64_t{integrator.max_depth});
      xml_.integer("rr_depth", integrator.rr_depth == 0 ? kNever : std::int64_t{integrator.rr_depth});
      if (!integrator.nee || !integrator.mis)
        differs("Mitsuba's path always combines light and material sampling; the light is the same, the noise is not");
    } else if (integrator.type == distance) {
      xml_.open("integrator", {{"type", "depth"}});
    } else {
      refuse("the integrator is neither path nor direct nor distance");
    }
    if (integrator.hide_emitters) xml_.boolean("hide_emitters", true);
    if (integrator.hide_background) differs("Mitsuba hides emitters and background together or neither");
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
      case radiance_meter:
        return "radiancemeter";
      case spherical:
        refuse("the camera is a panorama");
      case irradiance_meter:
        refuse("the camera measures irradiance at a place of its own");
    }
    throw std::logic_error("a camera of no type");
  }

  void write_sensor(const Camera& camera) {
    using enum Camera::Type;
    xml_.open("sensor", {{"type", word_of(camera.type)}});
    const bool widens = camera.type == perspective || camera.type == thin_lens;
    const double scale = widens ? even_scale(camera) : 1.0;
    if (widens) {
      constexpr const char* kAxes[] = {"x", "y", "diagonal", "smaller", "larger"};
      number("fov", camera.fov);
      xml_.text("fov_axis", kAxes[static_cast<std::size_t>(camera.fov_axis)]);
      if (camera.window.principal_offset.x != 0.0) number("principal_point_offset_x", camera.window.principal_offset.x);
      if (camera.window.principal_offset.y != 0.0) number("principal_point_offset_y", camera.window.principal_offset.y);
    }
    if (camera.type == thin_lens) {
      number("aperture_radius", camera.aperture.radius * scale);
      number("focus_distance", camera.aperture.focus_distance * scale);
      if (camera.aperture.blades > 0) differs("the aperture is a polygon, in Mitsuba a disk");
    }
    if (camera.type != radiance_meter) {
      number("near_clip", camera.near_clip * scale);
      number("far_clip", camera.far_clip * scale);
    }
    glm::dmat4 placement = camera.world_from_camera;
    for (int i = 0; i < 3; ++i) placement[i] /= scale;
    xml_.transform("to_world", placement);
    write_film(camera);
    if (!scene_.camera.path.empty())
      differs("the camera moves, which scenes for Mitsuba cannot say; --at TIME chooses a position");
    const bool sobol = scene_.sampler.type == Sampler::Type::sobol;
    xml_.open("sampler", {{"type", sobol ? "multijitter" : "independent"}});
    xml_.integer("sample_count", scene_.sampler.sample_count);
    xml_.close();
    xml_.close();
  }

  /// Cameras in Mitsuba may not be scaled, so their scale must be uniform to be removed.
  double even_scale(const Camera& camera) const {
    const glm::dmat3 axes(camera.world_from_camera);
    const double scale = glm::length(axes[2]);
    constexpr double kTolerance = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const double along = glm::length(axes[i]) / scale - 1.0;
      const double across = glm::dot(axes[i], axes[(i + 1) % 3]) / (scale * scale);
      if (std::abs(along) > kTolerance || std::abs(across) > kTolerance)
        refuse("the camera's toWorld shears or scales its axes differently");
    }
    return scale;
  }

  void write_film(const Camera& camera) {
    const auto whole = [](std::uint32_t pixels, double share) {
      return static_cast<std::int64_t>(std::llround(static_cast<double>(pixels) / share));
    };
    const FilmWindow& window = camera.window;
    const std::int64_t width = whole(camera.width, window.size.x), height = whole(camera.height, window.size.y);
    xml_.open("film", {{"type", "hdrfilm"}});
    xml_.integer("width", width);
    xml_.integer("height", height);
    if (width != camera.width || height != camera.height) {
      xml_.integer("crop_offset_x", std::llround(window.origin.x * static_cast<double>(width)));
      xml_.integer("crop_offset_y", std::llround(window.origin.y * static_cast<double>(height)));
      xml_.integer("crop_width", camera.width);
      xml_.integer("crop_height", camera.height);
    }
    xml_.text("pixel_format", "rgb");
    xml_.text("component_format", "float32");
    write_filter(camera.filter);
    xml_.close();
  }

  void write_filter(const ReconstructionFilter& filter) {
    using enum ReconstructionFilter::Type;
    switch (filter.type) {
      case box:
        if (filter.stretch != 1.0)
          differs(fmt::format("the box filter has a radius of {} pixels, in Mitsuba of 0.5", 0.5 * filter.stretch));
        return xml_.leaf("rfilter", {{"type", "box"}});
      case tent:
        xml_.open("rfilter", {{"type", "tent"}});
        if (filter.stretch != 1.0) number("radius", filter.stretch);
        break;
      case lanczos:
        xml_.open("rfilter", {{"type", "lanczos"}});
        xml_.integer("lobes", filter.lobes);
        break;
      case gaussian:
        if (filter.radius != 4.0 * filter.stddev)
          differs(
              fmt::format("the Gaussian filter ends at {} pixels, in Mitsuba at 4 standard deviations", filter.radius));
        xml_.open("rfilter", {{"type", "gaussian"}});
        number("stddev", filter.stddev);
        break;
      case mitchell:
        if (filter.radius != 2.0)
          differs(fmt::format("the filter has a radius of {} pixels, in Mitsuba of 2", filter.radius));
        xml_.open("rfilter", {{"type", "mitchell"}});
        number("A", filter.b);
        number("B", filter.c);
        break;
    }
    xml_.close();
  }

  void write_sky() {
    const Sky& sky = scene_.sky;
    if (is_dark(sky)) return;
    if (!sky.picture && sky.top == sky.horizon) {
      xml_.open("emitter", {{"type", "constant"}});
      color("radiance", sky.top);
      xml_.close();
      return;
    }
    xml_.open("emitter", {{"type", "envmap"}});
    if (!sky.picture) {
      differs("the sky's gradient is a picture of 1025 rows");
      xml_.text("filename", files_.picture(gradient_picture(sky)));
    } else if (sky.picture->rows == SkyPicture::Rows::circles) {
      xml_.text("filename", files_.picture(sky.picture->bitmap));
      number("scale", sky.picture->scale);
    } else {
      xml_.text("filename", files_.picture(picture_with_poles(*sky.picture)));
    }
    xml_.transform("to_world", glm::dmat4(sky.world_from_sky));
    xml_.close();
  }

  std::shared_ptr<const Bitmap> gradient_picture(const Sky& sky) {
    constexpr std::uint32_t kRows = 1025;
    auto bitmap = float_bitmap(2, kRows);
    for (std::uint32_t y = 0; y < kRows; ++y) {
      const double up = std::cos(std::numbers::pi * y / (kRows - 1));
      const glm::vec3 radiance(glm::mix(sky.horizon, sky.top, std::clamp(up, 0.0, 1.0)));
      for (std::uint32_t x = 0; x < 2; ++x) set_texel(*bitmap, x, y, radiance);
    }
    return bitmap;
  }

  /// The same light with other rows. Mitsuba's are at equal angles, the first and last at the poles; so every second
  /// row is the middle of a band, and those in between are the values at the edges of bands.
  std::shared_ptr<const Bitmap> picture_with_poles(const SkyPicture& picture) {
    const Bitmap& bands = *picture.bitmap;
    auto bitmap = float_bitmap(bands.width, 2 * bands.height + 1);
    for (std::uint32_t y = 0; y < bitmap->height; ++y) {
      for (std::uint32_t x = 0; x < bands.width; ++x) {
        const glm::vec3 above = picture.radiance(x, y == 0 ? 0 : (y - 1) / 2);
        const glm::vec3 below = picture.radiance(x, std::min(y / 2, bands.height - 1));
        set_texel(*bitmap, x, y, 0.5f * (above + below));
      }
    }
    return bitmap;
  }

  /// Writes the texture with an id at its first use, later a reference to it.
  void write_texture(const char* name, std::uint32_t row, const glm::dvec3& factor,
                     std::optional<TextureChannel> channel) override {
    const std::string id = fmt::format("texture-{}", textures_.size());
    const auto [known, is_new] = textures_.try_emplace({row, factor.x, factor.y, factor.z, channel}, id);
    if (!is_new) return xml_.leaf("ref", {{"name", name}, {"id", known->second}});
    Texture texture = scene_.textures[row];
    if (texture.vertex_tint) refuse("a texture is multiplied with the colours of a mesh");
    const auto* changed = texture.is_derived() ? std::get_if<BitmapTexture>(&texture.source) : nullptr;
    if (changed != nullptr && channel.value_or(TextureChannel::alpha) == TextureChannel::alpha) {
      differs("the alpha of texels is cut or multiplied before they are interpolated");
      open_picture(name, known->second, texture, *changed);
      xml_.text("filename", files_.picture(changed_by_alpha(texture, *changed, factor, channel.has_value())));
      xml_.boolean("raw", true);
      return xml_.close();
    }
    if (texture.is_derived()) refuse("a texture is changed by its alpha");
    if (channel.value_or(TextureChannel::luminance) != TextureChannel::luminance) {
      const auto* picture = std::get_if<BitmapTexture>(&texture.source);
      if (picture == nullptr) refuse("a number is a channel of a texture that is no picture");
      open_picture(name, known->second, texture, *picture);
      xml_.text("filename", files_.picture(channel_of(*picture, factor.x, *channel)));
      xml_.boolean("raw", true);
      return xml_.close();
    }
    require_first_set(texture);
    // See mitsuba_textures.cpp.
    auto* board = std::get_if<CheckerboardTexture>(&texture.source);
    if (channel && board != nullptr) {
      std::swap(board->color0, board->color1);
      std::swap(board->texture0, board->texture1);
    }
    std::visit([&](const auto& source) { write_source(name, id, texture, source, factor); }, texture.source);
    xml_.close();
  }
  void write_source(const char* name, const std::string& id, const Texture& texture, const BitmapTexture& source,
                    const glm::dvec3& factor) {
    const std::shared_ptr<const Bitmap>& bitmap = scene_.bitmaps[source.bitmap];
    const ColorSpace space = source.color_space.value_or(bitmap->color_space);
    open_picture(name, id, texture, source);
    xml_.text("filename",
              factor == glm::dvec3(1.0) ? files_.picture(bitmap) : files_.picture(scaled(*bitmap, space, factor)));
    if (space == ColorSpace::linear || factor != glm::dvec3(1.0)) xml_.boolean("raw", true);
  }
  /// Writes everything except the name of the file.
  void open_picture(const char* name, const std::string& id, const Texture& texture, const BitmapTexture& source) {
    constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};
    if (source.wrap_u != source.wrap_v) refuse("a texture is wrapped differently along u and v");
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "bitmap"}});
    xml_.text("wrap_mode", kWraps[static_cast<std::size_t>(source.wrap_u)]);
    xml_.text("filter_type", source.filter == TextureFilter::nearest ? "nearest" : "bilinear");
    write_uv(kFlipV * texture.uv_transform * kFlipV);
  }
  void write_source(const char* name, const std::string& id, const Texture& texture, const CheckerboardTexture& source,
                    const glm::dvec3& factor) {
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "checkerboard"}});
    color("color0", square(factor * source.color0, source.texture0));
    color("color1", square(factor * source.color1, source.texture1));
    write_uv(texture.uv_transform * kFlipV);
  }
  void write_source(const char* name, const std::string& id, const Texture&, const AttributeTexture& source,
                    const glm::dvec3& factor) {
    const bool faces = source.source == AttributeTexture::Source::face_color;
    if (factor.x != factor.y || factor.y != factor.z) refuse("colours of a mesh are multiplied by a colour");
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "mesh_attribute"}});
    xml_.text("name", faces ? "face_color" : "vertex_color");
    if (factor.x != 1.0) number("scale", factor.x);
  }
  void write_uv(const glm::dmat3& m) {
    xml_.transform("to_uv", {m[0][0], m[0][1], 0, 0, m[1][0], m[1][1], 0, 0, 0, 0, 1, 0, m[2][0], m[2][1], 0, 1});
  }
  std::shared_ptr<const Bitmap> scaled(const Bitmap& bitmap, ColorSpace space, const glm::dvec3& factor) {
    auto result = float_bitmap(bitmap.width, bitmap.height);
    for (std::uint32_t y = 0; y < bitmap.height; ++y) {
      for (std::uint32_t x = 0; x < bitmap.width; ++x)
        set_texel(*result, x, y, glm::vec3(factor * glm::dvec3(texel_color(bitmap, space, x, y))));
    }
    return result;
  }

  /// A picture whose alpha is compared with the texture's cutoff and multiplied in, or its alpha in all channels.
  std::shared_ptr<const Bitmap> changed_by_alpha(const Texture& texture, const BitmapTexture& source,
                                                 const glm::dvec3& factor, bool only_alpha) {
    const Bitmap& from = *scene_.bitmaps[source.bitmap];
    const ColorSpace space = source.color_space.value_or(from.color_space);
    auto result = float_bitmap(from.width, from.height);
    for (std::uint32_t y = 0; y < from.height; ++y) {
      for (std::uint32_t x = 0; x < from.width; ++x) {
        glm::dvec4 color = texel_color(from, space, x, y);
        if (texture.alpha_cutoff) color.a = color.a < *texture.alpha_cutoff ? 0.0 : 1.0;
        if (texture.premultiplied) color = glm::dvec4(glm::dvec3(color) * color.a, color.a);
        set_texel(*result, x, y, glm::vec3(factor * (only_alpha ? glm::dvec3(color.a) : glm::dvec3(color))));
      }
    }
    return result;
  }

  /// One channel as a grey picture, because Mitsuba only uses the luminance of a texture.
  std::shared_ptr<const Bitmap> channel_of(const BitmapTexture& source, double factor, TextureChannel channel) {
    const Bitmap& from = *scene_.bitmaps[source.bitmap];
    const ColorSpace space = source.color_space.value_or(from.color_space);
    auto grey = std::make_shared<Bitmap>();
    *grey = {.width = from.width, .height = from.height, .channels = 1, .format = BitmapFormat::f32};
    grey->texels.resize(grey->row_bytes() * grey->height);
    std::size_t at = 0;
    for (std::uint32_t y = 0; y < from.height; ++y) {
      for (std::uint32_t x = 0; x < from.width; ++x) {
        const auto value = static_cast<float>(factor * texel_color(from, space, x, y)[static_cast<int>(channel)]);
        std::memcpy(&grey->texels[at], &value, sizeof value);
        at += sizeof value;
      }
    }
    return grey;
  }

  void write_microfacet(const std::string&, const MicrofacetBsdf&) override {
    refuse("a material is Nori's microfacet");
  }
  /// Writes the nearest of Mitsuba's materials.
  void write_gltf(const std::string& id, const GltfBsdf& bsdf) override {
    const std::string sentence =
        "materials of glTF are written as principled, which has different lobes and no sheen, film, volume or "
        "dispersion, whose coat has the normal of the base, and whose anisotropy follows the tangent";
    if (std::ranges::find(differences_, sentence) == differences_.end()) differs(sentence);
    const bool sheet = bsdf.thin && may_refract(bsdf);
    open_bsdf(id, sheet ? "principledthin" : "principled");
    color("base_color", bsdf.base_color);
    number("roughness", bsdf.roughness);
    number("spec_trans", bsdf.transmission);
    number("eta", std::max(bsdf.ior.value, 1.0 + kMinIndexContrast));
    if (sheet) {
      ScalarParameter twice = bsdf.diffuse_transmission;
      twice.value *= 2.0;
      return number("diff_trans", twice);
    }
    number("metallic", bsdf.metallic);
    number("anisotropic", bsdf.anisotropy);
    number("clearcoat", bsdf.clearcoat);
  }
  void write_vertex_tangents() override {
    if (std::exchange(tangents_noted_, true)) return;
    differs(
        "normal maps follow vertex tangents; in Mitsuba they follow the texture coordinates of each triangle, and are "
        "not flipped where those are mirrored");
  }
  void note_masks() {
    const auto is_mask = [](const Material& material) {
      return material.adapter && std::holds_alternative<MaskAdapter>(*material.adapter);
    };
    if (!scene_.integrator.count_passes && std::ranges::any_of(scene_.materials, is_mask))
      differs("passing a mask does not count as a path segment, in Mitsuba it does");
  }

  void write_shape(const Instance& instance) {
    bool flip = instance.flip_normals;
    const Shape& shape = scene_.shape_of(instance);
    if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
      xml_.open("shape", {{"type", "ply"}});
      // In Mitsuba, normals of triangles follow from the winding in world space.
      if (mesh->normals.empty()) flip = flip != is_mirrored(instance.world_from_object);
      // Writes a mesh that is itself inside out: Mitsuba (3.9) joins meshes of one material, and fails if only some of
      // them are flipped.
      xml_.text("filename", files_.mesh(instance.shape, uv_set_of(instance), std::exchange(flip, false)));
      if (!mesh->uv_sets.empty()) xml_.boolean("flip_tex_coords", true);
      if (mesh->normals.empty()) xml_.boolean("face_normals", true);
    } else if (const auto* sphere = std::get_if<Sphere>(&shape)) {
      xml_.open("shape", {{"type", "sphere"}});
      xml_.property("point", "center", shortest(sphere->center));
      number("radius", sphere->radius);
      flip = flip != is_mirrored(instance.world_from_object);  // Mitsuba turns a mirrored sphere inside out
    } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
      xml_.open("shape", {{"type", "cylinder"}});
      xml_.property("point", "p0", shortest(cylinder->p0));
      xml_.property("point", "p1", shortest(cylinder->p1));
      number("radius", cylinder->radius);
    } else {
      xml_.open("shape", {{"type", "disk"}});
    }
    xml_.transform("to_world", instance.world_from_object);
    if (flip) xml_.boolean("flip_normals", true);
    refer_to(instance.material);
    if (const AreaEmitter* emitter = scene_.emitter_of(instance)) {
      xml_.open("emitter", {{"type", "area"}});
      color("radiance", emitter->radiance);
      if (emitter->two_sided && !std::exchange(sides_noted_, true))
        differs("two-sided lamps emit only in front in Mitsuba");
      xml_.close();
    }
    xml_.close();
  }

  std::vector<std::string> differences_;
  bool tangents_noted_ = false, sides_noted_ = false;
  /// Ids by row, factor and, for numbers, channel.
  std::map<std::tuple<std::uint32_t, double, double, double, std::optional<TextureChannel>>, std::string> textures_;
};

}  // namespace

std::vector<std::string> write_mitsuba_scene(const std::string& path, const Scene& scene, ExistingFiles existing) {
  MitsubaWriter writer(path, scene);
  writer.write(existing);
  return writer.differences();
}

std::string sensor_element(const Camera& camera, const Sampler& sampler) {
  Scene scene;
  scene.camera = camera;
  scene.sampler = sampler;
  return MitsubaWriter("the camera", scene).sensor_alone();
}

std::string mitsuba_bsdf_element(const Scene& scene, std::uint32_t row) {
  return MitsubaWriter("the material", scene).material_alone(row);
}

}  // namespace etendue
