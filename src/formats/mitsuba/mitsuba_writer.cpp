#include "formats/mitsuba/mitsuba_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/xml/xml_writer.h"
#include "scene/parameters.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

/// Mitsuba's v counts from a picture's first row, that of a Scene from its last.
const glm::dmat3 kFlip = {1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0};

bool is_mirrored(const glm::dmat4& m) {
  return glm::determinant(glm::dmat3(m)) < 0.0;
}

/// A picture of floats, linear.
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

class MitsubaWriter {
 public:
  MitsubaWriter(const std::string& path, const Scene& scene) : files_(path, scene), scene_(scene) {}

  void write(ExistingFiles existing) {
    xml_.open("scene", {{"version", "3.0.0"}});
    write_integrator(scene_.integrator);
    write_sensor(scene_.camera);
    write_sky();
    for (const DeltaLight& light : scene_.delta_lights) write_delta_light(light);
    for (const Instance& instance : scene_.instances) write_material(instance.material);
    for (const Instance& instance : scene_.instances) write_shape(instance);
    xml_.close();
    files_.write(xml_.result(), existing);
  }
  const std::vector<std::string>& differences() const { return differences_; }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorKind::scene,
                fmt::format("{}: {}, which Mitsuba does not have; nothing is written", scene_.file, what));
  }
  void differs(std::string sentence) { differences_.push_back(std::move(sentence)); }

  void color(const char* name, const glm::dvec3& value) { xml_.property("rgb", name, shortest(value)); }
  void color(const char* name, const ColorParameter& parameter) {
    if (!parameter.texture) return color(name, parameter.value);
    write_texture(name, *parameter.texture, parameter.value);
  }
  void number(const char* name, double value) { xml_.number(name, value); }

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
        differs("Mitsuba's path always samples lights and weighs strategies; its light is the same, its noise is not");
    } else {
      refuse("the integrator is neither path nor direct");
    }
    if (integrator.hide_emitters) xml_.boolean("hide_emitters", true);
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
    const bool sobol = scene_.sampler.type == Sampler::Type::sobol;
    xml_.open("sampler", {{"type", sobol ? "multijitter" : "independent"}});
    xml_.integer("sample_count", scene_.sampler.sample_count);
    xml_.close();
    xml_.close();
  }

  /// Cameras for Mitsuba are not scaled.
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
        return xml_.leaf("rfilter", {{"type", "box"}});
      case tent:
        return xml_.leaf("rfilter", {{"type", "tent"}});
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
      differs("the sky's picture is sampled again, with its first and last row at the poles, as Mitsuba wants it");
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

  /// Rows at the edges of the bands: a mean of two each, the first and last alone at the poles.
  std::shared_ptr<const Bitmap> picture_with_poles(const SkyPicture& picture) {
    const Bitmap& bands = *picture.bitmap;
    auto bitmap = float_bitmap(bands.width, bands.height + 1);
    for (std::uint32_t y = 0; y <= bands.height; ++y) {
      for (std::uint32_t x = 0; x < bands.width; ++x) {
        const glm::vec3 above = picture.radiance(x, y == 0 ? 0 : y - 1);
        const glm::vec3 below = picture.radiance(x, std::min(y, bands.height - 1));
        set_texel(*bitmap, x, y, 0.5f * (above + below));
      }
    }
    return bitmap;
  }

  /// At its first use with an id, later by that.
  void write_texture(const char* name, std::uint32_t row, const glm::dvec3& factor) {
    const std::string id = fmt::format("texture-{}", textures_.size());
    const auto [known, is_new] = textures_.try_emplace({row, factor.x, factor.y, factor.z}, id);
    if (!is_new) return xml_.leaf("ref", {{"name", name}, {"id", known->second}});
    const Texture& texture = scene_.textures[row];
    if (texture.uv_set > 0) refuse("a texture uses the second texture coordinates of a mesh");
    std::visit([&](const auto& source) { write_source(name, known->second, texture, source, factor); }, texture.source);
    xml_.close();
  }
  void write_source(const char* name, const std::string& id, const Texture& texture, const BitmapTexture& source,
                    const glm::dvec3& factor) {
    constexpr const char* kWraps[] = {"repeat", "mirror", "clamp"};
    const std::shared_ptr<const Bitmap>& bitmap = scene_.bitmaps[source.bitmap];
    const ColorSpace space = source.color_space.value_or(bitmap->color_space);
    if (source.wrap_u != source.wrap_v) refuse("a texture is wrapped differently along u and v");
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "bitmap"}});
    xml_.text("filename",
              factor == glm::dvec3(1.0) ? files_.picture(bitmap) : files_.picture(scaled(*bitmap, space, factor)));
    if (space == ColorSpace::linear || factor != glm::dvec3(1.0)) xml_.boolean("raw", true);
    xml_.text("wrap_mode", kWraps[static_cast<std::size_t>(source.wrap_u)]);
    xml_.text("filter_type", source.filter == TextureFilter::nearest ? "nearest" : "bilinear");
    write_uv(kFlip * texture.uv_transform * kFlip);
  }
  void write_source(const char* name, const std::string& id, const Texture& texture, const CheckerboardTexture& source,
                    const glm::dvec3& factor) {
    xml_.open("texture", {{"name", name}, {"id", id}, {"type", "checkerboard"}});
    color("color0", factor * source.color0);
    color("color1", factor * source.color1);
    write_uv(texture.uv_transform * kFlip);
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

  static std::string material_id(std::uint32_t row) { return fmt::format("material-{}", row); }

  void write_material(std::uint32_t row) {
    if (!written_.insert(row).second) return;
    const Material& material = scene_.materials[row];
    if (material.adapter) {
      each_choice(*material.adapter, [&](std::uint32_t choice) { write_material(choice); });
      std::visit([&](const auto& adapter) { write_adapter(material_id(row), adapter); }, *material.adapter);
    } else {
      std::visit([&](const auto& bsdf) { write_bsdf(material_id(row), bsdf); }, material.bsdf);
    }
    xml_.close();
  }
  void refer_to(std::uint32_t row) { xml_.leaf("ref", {{"id", material_id(row)}}); }
  void write_adapter(const std::string& id, const TwoSidedAdapter& adapter) {
    open_bsdf(id, "twosided");
    refer_to(adapter.front);
    if (adapter.back != adapter.front) refer_to(adapter.back);
  }
  void write_adapter(const std::string& id, const MaskAdapter& mask) {
    open_bsdf(id, "mask");
    number("opacity", mask.opacity);
    refer_to(mask.inner);
    if (!scene_.integrator.count_passes) differs("a mask makes no path longer, in Mitsuba it does");
  }
  void write_adapter(const std::string& id, const NormalMapAdapter& map) {
    open_bsdf(id, "normalmap");
    color("normalmap", map.normals);
    refer_to(map.inner);
  }
  void write_adapter(const std::string& id, const BumpMapAdapter& map) {
    open_bsdf(id, "bumpmap");
    ScalarParameter height = map.height;
    height.value = 1.0;
    number("displacement", height);
    number("scale", map.height.value);
    refer_to(map.inner);
  }
  void write_adapter(const std::string& id, const BlendAdapter& blend) {
    open_bsdf(id, "blendbsdf");
    number("weight", blend.weight);
    refer_to(blend.first);
    refer_to(blend.second);
  }
  void number(const char* name, const ScalarParameter& parameter) {
    if (!parameter.texture) return number(name, parameter.value);
    if (parameter.channel != TextureChannel::luminance) refuse("a number is a channel of a texture");
    write_texture(name, *parameter.texture, glm::dvec3(parameter.value));
  }
  void open_bsdf(const std::string& id, const char* type) { xml_.open("bsdf", {{"type", type}, {"id", id}}); }

  void write_bsdf(const std::string& id, const DiffuseBsdf& bsdf) {
    open_bsdf(id, "diffuse");
    color("reflectance", bsdf.albedo);
  }
  void write_bsdf(const std::string& id, const MirrorBsdf&) { open_bsdf(id, "conductor"); }
  void write_bsdf(const std::string& id, const DielectricBsdf& bsdf) {
    open_bsdf(id, "dielectric");
    write_indices(bsdf);
  }
  void write_bsdf(const std::string& id, const PrincipledBsdf& bsdf) {
    open_bsdf(id, "principled");
    each_parameter(bsdf, [&](const char* name, const auto& parameter) {
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameter)>, ColorParameter>)
        color(name, parameter);
      else
        number(name, parameter);
    });
    number("sheen_tint", bsdf.sheen_tint);
    number("flatness", bsdf.flatness);
    number("clearcoat_gloss", bsdf.clearcoat_gloss);
    number("eta", bsdf.eta);
  }
  void write_bsdf(const std::string& id, const NullBsdf&) { open_bsdf(id, "null"); }
  void write_bsdf(const std::string&, const MicrofacetBsdf&) { refuse("a material is Nori's microfacet"); }
  void write_bsdf(const std::string& id, const ConductorBsdf& bsdf) {
    open_bsdf(id, "conductor");
    write_metal(bsdf);
  }
  void write_bsdf(const std::string& id, const RoughConductorBsdf& bsdf) {
    open_bsdf(id, "roughconductor");
    write_metal(bsdf);
    write_roughness(bsdf.roughness);
  }
  void write_bsdf(const std::string& id, const RoughDielectricBsdf& bsdf) {
    open_bsdf(id, "roughdielectric");
    write_clear(bsdf);
    write_roughness(bsdf.roughness);
  }
  void write_bsdf(const std::string& id, const ThinDielectricBsdf& bsdf) {
    open_bsdf(id, "thindielectric");
    write_clear(bsdf);
  }
  void write_bsdf(const std::string& id, const PlasticBsdf& bsdf) {
    open_bsdf(id, "plastic");
    write_plastic(bsdf);
  }
  void write_bsdf(const std::string& id, const RoughPlasticBsdf& bsdf) {
    open_bsdf(id, "roughplastic");
    write_plastic(bsdf);
    write_distribution(bsdf.distribution);
    number("alpha", bsdf.alpha);
  }

  template <typename Glass>
  void write_indices(const Glass& bsdf) {
    number("int_ior", bsdf.int_ior);
    number("ext_ior", bsdf.ext_ior);
  }
  template <typename Metal>
  void write_metal(const Metal& bsdf) {
    color("eta", bsdf.index.eta);
    color("k", bsdf.index.k);
    color("specular_reflectance", bsdf.specular_reflectance);
  }
  template <typename Glass>
  void write_clear(const Glass& bsdf) {
    write_indices(bsdf);
    color("specular_reflectance", bsdf.specular_reflectance);
    color("specular_transmittance", bsdf.specular_transmittance);
  }
  template <typename Plastic>
  void write_plastic(const Plastic& bsdf) {
    write_indices(bsdf);
    color("diffuse_reflectance", bsdf.diffuse_reflectance);
    color("specular_reflectance", bsdf.specular_reflectance);
    xml_.boolean("nonlinear", bsdf.nonlinear);
  }
  void write_distribution(Roughness::Distribution distribution) {
    xml_.text("distribution", distribution == Roughness::Distribution::ggx ? "ggx" : "beckmann");
  }
  void write_roughness(const Roughness& roughness) {
    write_distribution(roughness.distribution);
    number("alpha_u", roughness.alpha_u);
    number("alpha_v", roughness.alpha_v);
  }

  void write_shape(const Instance& instance) {
    bool flip = instance.flip_normals;
    const Shape& shape = scene_.shape_of(instance);
    if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
      xml_.open("shape", {{"type", "ply"}});
      xml_.text("filename", files_.mesh(instance.shape));
      if (!mesh->uv_sets.empty()) xml_.boolean("flip_tex_coords", true);
      // There, normals of triangles follow from the order of their vertices in the world.
      if (mesh->normals.empty()) {
        xml_.boolean("face_normals", true);
        flip = flip != is_mirrored(instance.world_from_object);
      }
    } else if (const auto* sphere = std::get_if<Sphere>(&shape)) {
      xml_.open("shape", {{"type", "sphere"}});
      xml_.property("point", "center", shortest(sphere->center));
      number("radius", sphere->radius);
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
    xml_.leaf("ref", {{"id", material_id(instance.material)}});
    if (const AreaEmitter* emitter = scene_.emitter_of(instance)) {
      xml_.open("emitter", {{"type", "area"}});
      color("radiance", emitter->radiance);
      xml_.close();
    }
    xml_.close();
  }

  SceneFiles files_;
  const Scene& scene_;
  XmlWriter xml_;
  std::vector<std::string> differences_;
  std::map<std::tuple<std::uint32_t, double, double, double>, std::string> textures_;  ///< ids by row and factor
  std::set<std::uint32_t> written_;                                                    ///< materials
};

}  // namespace

std::vector<std::string> write_mitsuba_scene(const std::string& path, const Scene& scene, ExistingFiles existing) {
  MitsubaWriter writer(path, scene);
  writer.write(existing);
  return writer.differences();
}

}  // namespace etendue
