#include "scene/invariants.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "image/vectors.h"
#include "scene/bounds.h"
#include "scene/limits.h"
#include "scene/materials.h"
#include "scene/parameters.h"
#include "scene/placed.h"
#include "scene/similarity.h"
#include "scene/texture_checks.h"
#include "scene/view.h"

namespace etendue {
namespace {

/// Affine, finite and invertible.
bool is_usable(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(m[column][row])) return false;
    }
  }
  const bool affine = m[0][3] == 0.0 && m[1][3] == 0.0 && m[2][3] == 0.0 && m[3][3] == 1.0;
  // The determinant of tiny or huge axes leaves the range of a double; that of unit axes does not.
  glm::dmat3 axes(m);
  for (int a = 0; a < 3; ++a) {
    const double length = largest_coordinate(axes[a]);
    if (!(length > 0.0)) return false;
    axes[a] /= length;
  }
  return affine && glm::determinant(axes) != 0.0;
}

class Checker {
 public:
  Checker(const Scene& scene, Diagnostics& sink, const LocateField& locate)
      : scene_(scene), sink_(sink), locate_(locate) {}

  void check() {
    check_camera();
    check_sampler_and_integrator();
    check_lights();
    check_numbers();
    check_totals();
    if (tables_fit()) {
      check_adapters();
      shapes_.resize(scene_.shapes.size());
      for (const Instance& instance : scene_.instances) check_instance(instance);
      check_textures(scene_, sink_, locate_);
    }
  }

  void check_lights() {
    check_sky();
    for (const AreaEmitter& emitter : scene_.emitters)
      check_radiance(emitter.radiance.value, emitter.position, "radiance");
    for (const DeltaLight& light : scene_.delta_lights) check_delta_light(light);
  }

  /// Checks a scene whose tables are consistent.
  void check_materials() {
    check_numbers();
    check_adapters();
  }

 private:
  SourcePosition place(const SourcePosition& object, std::string_view field) const {
    if (locate_) {
      if (const auto position = locate_(object, field)) return *position;
    }
    return object;
  }
  void error(const SourcePosition& object, std::string_view field, std::string message) {
    sink_.error(place(object, field), std::move(message));
  }

  void check_camera() {
    const Camera& camera = scene_.camera;
    const std::int64_t width = camera.width, height = camera.height;
    if (width < 1 || height < 1 || width * height > kMaxPixels) {
      error(camera.position, "width",
            fmt::format("the film has {} × {} = {} pixels; at most {} are supported, and at least one", width, height,
                        width * height, kMaxPixels));
    }
    if (!(camera.fov > 0.0 && camera.fov < 180.0))
      error(camera.position, "fov",
            fmt::format("the field of view is {} degrees; it must lie between 0 and 180", camera.fov));
    if (!(camera.near_clip >= 0.0 && std::isfinite(camera.near_clip)) || !(camera.near_clip < camera.far_clip)) {
      const bool far_given = locate_ && locate_(camera.position, "far_clip");
      error(camera.position, far_given ? "far_clip" : "near_clip",
            fmt::format("the near clipping distance (nearClip) {} is not less than the far one (farClip), {}; nothing "
                        "would be visible",
                        camera.near_clip, camera.far_clip));
    }
    if (const std::string complaint = path_complaint(camera.path); !complaint.empty())
      error(camera.position, "path", complaint);
    const glm::dvec3 origin(camera.world_from_camera[3]);
    if (!is_usable(camera.world_from_camera)) {
      error(camera.position, "world_from_camera", "the camera's transform is not affine, finite and invertible");
    } else if (!(largest_coordinate(origin) <= kMaxCoordinate)) {
      error(camera.position, "world_from_camera",
            fmt::format("the camera is at {} {} {}; coordinates up to {} are supported", origin.x, origin.y, origin.z,
                        kMaxCoordinate));
    }
    check_window_and_aperture(camera);
    const ReconstructionFilter& filter = camera.filter;
    const bool usable = filter.radius > 0.0 && std::isfinite(filter.radius) && filter.stddev > 0.0 &&
                        std::isfinite(filter.stddev) && std::isfinite(filter.b) && std::isfinite(filter.c) &&
                        filter.stretch > 0.0 && std::isfinite(filter.stretch) && filter.lobes >= 1 &&
                        filter.lobes <= kMaxFilterLobes;
    if (!usable)
      error(
          camera.position, "filter",
          fmt::format("the pixel filter has radius {}, standard deviation {}, B {}, C {}, stretch {} and {} lobes; "
                      "they must be finite, radius, deviation and stretch above 0, lobes 1 to {}",
                      filter.radius, filter.stddev, filter.b, filter.c, filter.stretch, filter.lobes, kMaxFilterLobes));
  }

  void check_window_and_aperture(const Camera& camera) {
    const FilmWindow& w = camera.window;
    const bool finite = std::isfinite(w.origin.x) && std::isfinite(w.origin.y) && std::isfinite(w.principal_offset.x) &&
                        std::isfinite(w.principal_offset.y);
    if (!finite || !(w.size.x > 0.0 && w.size.y > 0.0 && w.size.x <= 1.0 && w.size.y <= 1.0))
      error(camera.position, "window",
            fmt::format("the part of the film that is rendered is {} by {} of it; both must be above 0 and at most 1",
                        w.size.x, w.size.y));
    const Aperture& a = camera.aperture;
    if (!(a.radius >= 0.0 && std::isfinite(a.radius)) || !(a.focus_distance > 0.0 && std::isfinite(a.focus_distance)))
      error(camera.position, "aperture",
            fmt::format("a lens of radius {} is focused at distance {}; the radius must not be negative, the distance "
                        "must be above 0",
                        a.radius, a.focus_distance));
    constexpr std::uint32_t kMaxBlades = 1000;
    if (a.blades == 1 || a.blades == 2 || a.blades > kMaxBlades || !std::isfinite(a.rotation))
      error(camera.position, "aperture",
            fmt::format("an aperture has {} corners, turned by {} degrees; use 3 to {}, or 0 for a disk", a.blades,
                        a.rotation, kMaxBlades));
  }

  void check_sampler_and_integrator() {
    constexpr std::uint32_t kMaxSetBits = 12;
    if (scene_.sampler.sample_count < 1)
      error(scene_.position, "sample_count", "the sampler takes 0 samples per pixel; take at least 1");
    if (scene_.sampler.set_bits > kMaxSetBits)
      error(scene_.position, "set_bits",
            fmt::format("a set of the sampler has 2^{} paths; at most 2^{} are supported", scene_.sampler.set_bits,
                        kMaxSetBits));
    if (scene_.integrator.max_depth < 1 || scene_.integrator.max_depth > Integrator::kUnlimitedDepth)
      error(scene_.position, "max_depth",
            fmt::format("paths of at most {} segments are requested; 1 to {} are supported",
                        scene_.integrator.max_depth, Integrator::kUnlimitedDepth));
    check_integrator(scene_.integrator);
    check_aovs();
  }

  void check_aovs() {
    for (const Aov aov : scene_.aovs) {
      const std::string complaint = aov_complaint(scene_.integrator, aov);
      if (!complaint.empty()) error(scene_.position, "aovs", complaint);
    }
    const bool light = scene_.integrator.aov == Aov::direct || scene_.integrator.aov == Aov::indirect;
    if (scene_.integrator.type == Integrator::Type::aov && light)
      error(scene_.position, "aov", "direct and indirect light are parts of what path, direct or whitted gathers");
  }

  void check_integrator(const Integrator& integrator) {
    const std::uint32_t emitter = integrator.emitter_samples, bsdf = integrator.bsdf_samples;
    if (std::max(emitter, bsdf) < 1 || std::max(emitter, bsdf) > kMaxDirectSamples)
      error(
          scene_.position, "emitter_samples",
          fmt::format("the integrator takes {} emitter samples and {} bsdf samples; take at least one of either kind, "
                      "and at most {} of each",
                      emitter, bsdf, kMaxDirectSamples));
    if (!(integrator.length > 0.0))
      error(scene_.position, "length",
            fmt::format("rays of length {} reach nothing; the length must be above 0", integrator.length));
    const SimpleLight& light = integrator.light;
    if (!(largest_coordinate(light.position) <= kMaxCoordinate))
      error(scene_.position, "position",
            fmt::format("the light is at {} {} {}; coordinates up to {} are supported", light.position.x,
                        light.position.y, light.position.z, kMaxCoordinate));
    for (const double component : {light.energy.x, light.energy.y, light.energy.z}) {
      if (!(component >= 0.0 && component <= kMaxRadiance))
        error(scene_.position, "energy", fmt::format("the energy {} is not between 0 and {}", component, kMaxRadiance));
    }
  }

  void check_radiance(const glm::dvec3& radiance, const SourcePosition& object, std::string_view field) {
    for (const double component : {radiance.x, radiance.y, radiance.z}) {
      if (component == 0.0 || (component >= kMinRadiance && component <= kMaxRadiance)) continue;
      const char* wrong =
          component > 0.0 && component < kMinRadiance ? "too small for single precision" : "out of range";
      return error(object, field,
                   fmt::format("radiance {} is {}; use 0, or {} to {}", component, wrong, kMinRadiance, kMaxRadiance));
    }
  }

  void check_delta_light(const DeltaLight& light) {
    const std::string name = text::quoted(light.name);
    check_radiance(light.intensity.value, light.position, "intensity");
    if (!is_usable(light.world_from_light) || !is_similarity(light.world_from_light))
      error(light.position, "world_from_light",
            fmt::format("the transform of the light {} scales it unevenly or shears it, or is not invertible; use "
                        "rotations, reflections and translations",
                        name));
    if (const glm::dvec3 p = light.origin(); !(largest_coordinate(p) <= kMaxCoordinate))
      error(light.position, "world_from_light",
            fmt::format("the light {} is at {} {} {}; coordinates up to {} are supported", name, p.x, p.y, p.z,
                        kMaxCoordinate));
    if (light.type == DeltaLight::Type::spot) check_spot(light);
    if (light.type == DeltaLight::Type::projector &&
        !(std::min(light.slope.x, light.slope.y) > 0.0 && std::max(light.slope.x, light.slope.y) <= kMaxSlope))
      error(light.position, "slope",
            fmt::format("the picture of the projector {} is {} by {} at distance 1; sides above 0 and up to {} are "
                        "supported",
                        name, 2.0 * light.slope.x, 2.0 * light.slope.y, 2.0 * kMaxSlope));
  }

  void check_spot(const DeltaLight& light) {
    const double most = light.intensity.texture ? kMaxTexturedCutoff : 180.0;
    if (!(light.cutoff > 0.0 && light.cutoff <= most))
      error(light.position, "cutoff",
            fmt::format("the cone of the spot {} has a half angle of {} degrees; use above 0 and up to {}",
                        text::quoted(light.name), light.cutoff, most));
    if (!(light.beam_width >= 0.0 && light.beam_width <= light.cutoff))
      error(light.position, "beam_width",
            fmt::format("the beam of the spot {} has a half angle of {} degrees, its cone one of {}; the beam must be "
                        "within the cone",
                        text::quoted(light.name), light.beam_width, light.cutoff));
  }

  void check_sky() {
    const Sky& sky = scene_.sky;
    check_radiance(sky.top, scene_.position, "sky_top");
    check_radiance(sky.horizon, scene_.position, "sky_horizon");
    if (const glm::dmat4 turn(sky.world_from_sky); !is_usable(turn) || !is_similarity(turn)) {
      error(scene_.position, "world_from_sky",
            "the transform of the environment scales it unevenly or shears it; use rotations, reflections and uniform "
            "scale");
    }
    if (sky.picture) check_sky_picture(*sky.picture);
  }

  void check_sky_picture(const SkyPicture& picture) {
    const Bitmap* bitmap = picture.bitmap.get();
    if (bitmap == nullptr || bitmap->width < 1 || bitmap->height < 1 || bitmap->channels < 1 || bitmap->channels > 4 ||
        bitmap->texels.size() != bitmap->row_bytes() * bitmap->height) {
      return error(scene_.position, "sky_picture", "the picture of the environment has no texels, or too few");
    }
    if (!(picture.scale > 0.0 && std::isfinite(picture.scale))) {
      return error(scene_.position, "sky_scale",
                   fmt::format("the scale of the environment is {}; it must be above 0 and finite", picture.scale));
    }
    const SkyStatistics statistics = sky_statistics(picture);
    if (!(statistics.smallest >= 0.0)) {
      error(scene_.position, "sky_picture",
            fmt::format("the picture of the environment has a radiance of {}; light is not negative",
                        statistics.smallest));
    }
    if (!(statistics.largest <= kMaxRadiance)) {
      error(scene_.position, "sky_picture",
            fmt::format("the picture of the environment has a radiance of {}; use at most {}", statistics.largest,
                        kMaxRadiance));
    }
  }

  void check_numbers() {
    for (const Material& material : scene_.materials) {
      if (material.adapter) {
        std::visit([&](const auto& adapter) { check_adapter(adapter, material); }, *material.adapter);
      } else {
        std::visit([&](const auto& bsdf) { check_bsdf(bsdf, material); }, material.bsdf);
      }
    }
  }

  void check_bsdf(const DiffuseBsdf& bsdf, const Material& material) {
    const glm::dvec3& albedo = bsdf.albedo.value;
    if (!is_finite(albedo))
      error(material.position, "albedo", fmt::format("albedo {} {} {} is not finite", albedo.x, albedo.y, albedo.z));
  }
  void check_bsdf(const MirrorBsdf&, const Material&) {}
  void check_bsdf(const NullBsdf&, const Material&) {}
  void check_bsdf(const PrincipledBsdf& bsdf, const Material& material) { check_ranges(bsdf, material); }
  void check_bsdf(const PrincipledThinBsdf& bsdf, const Material& material) { check_ranges(bsdf, material); }
  void check_bsdf(const GltfBsdf& bsdf, const Material& material) {
    check_ranges(bsdf, material);
    if (!(bsdf.dispersion >= 0.0 && bsdf.dispersion <= kMaxDispersion))
      error(material.position, "dispersion",
            fmt::format("dispersion {} is not between 0 and {}", bsdf.dispersion, kMaxDispersion));
    if (bsdf.coat_normals.texture && (!bsdf.coat_keeps_normal || bsdf.coat_normals.value != glm::dvec3(1.0)))
      error(material.position, "coat_normals",
            "the coat's normal map is a texture, times 1, of a coat that keeps its normal");
    if (bsdf.anisotropy_directions.texture && bsdf.anisotropy_directions.value != glm::dvec3(1.0))
      error(material.position, "anisotropy_directions", "the directions of anisotropy are a texture, times 1");
    if (!std::isfinite(bsdf.anisotropy_rotation))
      error(material.position, "anisotropy_rotation",
            fmt::format("anisotropy_rotation {} is not finite", bsdf.anisotropy_rotation));
    const glm::dvec3& c = bsdf.attenuation_color;
    if (!(std::min({c.x, c.y, c.z}) >= kMinAttenuation && std::max({c.x, c.y, c.z}) <= 1.0))
      error(material.position, "attenuation_color",
            fmt::format("attenuation_color {} {} {} is not between {} and 1", c.x, c.y, c.z, kMinAttenuation));
    if (!(bsdf.attenuation_distance > 0.0))
      error(material.position, "attenuation_distance",
            fmt::format("attenuation_distance {} is not above 0", bsdf.attenuation_distance));
  }
  /// Of materials whose parameters all have a range, but for relative indices.
  template <typename T>
  void check_ranges(const T& bsdf, const Material& material) {
    each_parameter(bsdf, [&](const char* field, const auto& parameter) {
      const ParameterRange range = parameter_range(bsdf, field);
      if (parameter.texture) return check_factor(material, field, glm::dvec3(parameter.value));
      if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameter)>, ScalarParameter>) {
        if (std::string_view(field) == "eta") return check_relative_index(material, parameter.value);
      }
      const glm::dvec3 v(parameter.value);
      if (std::min({v.x, v.y, v.z}) >= range.least && std::max({v.x, v.y, v.z}) <= range.most) return;
      constexpr bool kColor = std::is_same_v<std::remove_cvref_t<decltype(parameter)>, ColorParameter>;
      const std::string value = kColor ? fmt::format("{} {} {}", v.x, v.y, v.z) : fmt::format("{}", v.x);
      error(material.position, field,
            fmt::format("{} {} is not between {} and {}", field, value, range.least, range.most));
    });
  }
  void check_relative_index(const Material& material, double eta) {
    check_indices(material, eta, 1.0);
    if (!(std::abs(eta - 1.0) >= kMinIndexContrast))
      error(material.position, "eta",
            fmt::format("the index of refraction {} is 1, or nearly; it must differ by {}, or nothing is bent", eta,
                        kMinIndexContrast));
  }
  void check_bsdf(const DielectricBsdf& bsdf, const Material& material) {
    check_indices(material, bsdf.int_ior, bsdf.ext_ior);
    check_reflectance(material, "specular_reflectance", bsdf.specular_reflectance);
    check_reflectance(material, "specular_transmittance", bsdf.specular_transmittance);
  }

  void check_roughness(const Material& material, const char* field, const ScalarParameter& alpha) {
    if (!alpha.texture) return check_roughness(material, field, alpha.value);
    check_factor(material, field, glm::dvec3(alpha.value));
  }
  void check_roughness(const Material& material, const char* field, double alpha) {
    if (!(alpha >= kMinRoughness && alpha <= 1.0))
      error(material.position, field,
            fmt::format("the roughness {} is not between {} and 1; below that a smooth material is the same to the eye",
                        alpha, kMinRoughness));
  }
  /// What a texture is multiplied with, before it is brought into range.
  void check_factor(const Material& material, const char* field, const glm::dvec3& factor) {
    if (!is_finite(factor) || std::min({factor.x, factor.y, factor.z}) < 0.0)
      error(material.position, field,
            fmt::format("the factor {} {} {} of a texture is negative or not finite", factor.x, factor.y, factor.z));
  }
  /// A factor of what arrives.
  void check_reflectance(const Material& material, const char* field, const ColorParameter& parameter) {
    if (parameter.texture) return check_factor(material, field, parameter.value);
    const glm::dvec3& color = parameter.value;
    if (!(std::min({color.x, color.y, color.z}) >= 0.0 && std::max({color.x, color.y, color.z}) <= 1.0))
      error(material.position, field,
            fmt::format("{} {} {} {} is not between 0 and 1", field, color.x, color.y, color.z));
  }
  void check_indices(const Material& material, double int_ior, double ext_ior) {
    for (const double ior : {int_ior, ext_ior}) {
      if (!(ior > 0.0 && std::isfinite(ior)))
        error(material.position, "int_ior", fmt::format("the index of refraction {} is not above 0 and finite", ior));
    }
  }
  void check_index(const Material& material, const ConductorIndex& index) {
    each_parameter(index, [&](const char* field, const ColorParameter& parameter) {
      if (parameter.texture) return check_factor(material, field, parameter.value);
      const glm::dvec3& part = parameter.value;
      if (!(std::min({part.x, part.y, part.z}) >= 0.0 && std::max({part.x, part.y, part.z}) <= kMaxConductorIndex))
        error(material.position, field,
              fmt::format("{} {} {} is not a complex index of refraction; eta and k are between 0 and {}", part.x,
                          part.y, part.z, kMaxConductorIndex));
    });
  }
  void check_bsdf(const MicrofacetBsdf& bsdf, const Material& material) {
    check_reflectance(material, "kd", bsdf.kd);
    check_roughness(material, "alpha", bsdf.alpha);
    check_indices(material, bsdf.int_ior, bsdf.ext_ior);
  }
  void check_bsdf(const ConductorBsdf& bsdf, const Material& material) {
    check_index(material, bsdf.index);
    check_reflectance(material, "specular_reflectance", bsdf.specular_reflectance);
  }
  void check_bsdf(const RoughConductorBsdf& bsdf, const Material& material) {
    check_index(material, bsdf.index);
    check_reflectance(material, "specular_reflectance", bsdf.specular_reflectance);
    check_roughness(material, "alpha_u", bsdf.roughness.alpha_u);
    check_roughness(material, "alpha_v", bsdf.roughness.alpha_v);
  }

  void check_bsdf(const RoughDielectricBsdf& bsdf, const Material& material) {
    check_indices(material, bsdf.int_ior, bsdf.ext_ior);
    if (!(std::abs(bsdf.int_ior / bsdf.ext_ior - 1.0) >= kMinIndexContrast))
      error(material.position, "int_ior",
            fmt::format("the indices of refraction {} and {} of a rough dielectric are equal, or nearly; they must "
                        "differ by {} of themselves, or nothing is bent",
                        bsdf.int_ior, bsdf.ext_ior, kMinIndexContrast));
    check_roughness(material, "alpha_u", bsdf.roughness.alpha_u);
    check_roughness(material, "alpha_v", bsdf.roughness.alpha_v);
    check_reflectance(material, "specular_reflectance", bsdf.specular_reflectance);
    check_reflectance(material, "specular_transmittance", bsdf.specular_transmittance);
  }
  void check_bsdf(const ThinDielectricBsdf& bsdf, const Material& material) {
    check_indices(material, bsdf.int_ior, bsdf.ext_ior);
    check_reflectance(material, "specular_reflectance", bsdf.specular_reflectance);
    check_reflectance(material, "specular_transmittance", bsdf.specular_transmittance);
  }
  /// Of both plastics.
  template <typename Plastic>
  void check_plastic(const Plastic& bsdf, const Material& material) {
    check_indices(material, bsdf.int_ior, bsdf.ext_ior);
    check_reflectance(material, "diffuse_reflectance", bsdf.diffuse_reflectance);
    check_reflectance(material, "specular_reflectance", bsdf.specular_reflectance);
    if (!(bsdf.int_ior > bsdf.ext_ior) || !(bsdf.int_ior / bsdf.ext_ior <= kMaxCoatIndex))
      error(material.position, "int_ior",
            fmt::format("the indices of refraction {} inside and {} outside are no coat of plastic; inside must be "
                        "more than outside, and at most {} times as much",
                        bsdf.int_ior, bsdf.ext_ior, kMaxCoatIndex));
  }
  void check_bsdf(const PlasticBsdf& bsdf, const Material& material) { check_plastic(bsdf, material); }
  void check_bsdf(const RoughPlasticBsdf& bsdf, const Material& material) {
    check_plastic(bsdf, material);
    check_roughness(material, "alpha", bsdf.alpha);
  }

  void check_adapter(const TwoSidedAdapter&, const Material&) {}
  void check_adapter(const MaskAdapter& mask, const Material& material) {
    check_probability(material, "opacity", mask.opacity.value);
  }
  void check_adapter(const BlendAdapter& blend, const Material& material) {
    check_probability(material, "weight", blend.weight.value);
  }
  void check_adapter(const NormalMapAdapter& map, const Material& material) {
    if (!map.normals.texture || map.normals.value != glm::dvec3(1.0))
      error(material.position, "normals", "a normal map is a texture, times 1; give one");
  }
  void check_adapter(const BumpMapAdapter& map, const Material& material) {
    if (!map.height.texture || !std::isfinite(map.height.value))
      error(material.position, "height",
            fmt::format("a bump map is a picture times a finite number, here {}; give both", map.height.value));
  }
  void check_probability(const Material& material, const char* field, double value) {
    if (!(value >= 0.0 && value <= 1.0))
      error(material.position, field, fmt::format("{} {} is not between 0 and 1", field, value));
  }

  /// Adapters as a whole: how deep they stand one in the other, and what has no back of its own.
  void check_adapters() {
    std::vector<std::uint32_t> depths;
    for (std::uint32_t row = 0; row < scene_.materials.size(); ++row) {
      const Material& material = scene_.materials[row];
      std::uint32_t depth = 0;
      if (material.adapter)
        each_choice(*material.adapter, [&](std::uint32_t choice) { depth = std::max(depth, depths[choice] + 1); });
      depths.push_back(depth);
      if (depth == kMaxAdapterDepth + 1)
        sink_.error(material.position, fmt::format("{} is inside {} nested adapters; at most {} are supported",
                                                   text::quoted(material.name), depth, kMaxAdapterDepth));
      if (material.adapter && std::holds_alternative<TwoSidedAdapter>(*material.adapter)) check_two_sided(row);
    }
  }

  void check_two_sided(std::uint32_t row) {
    const Material& two_sided = scene_.materials[row];
    each_material(scene_, row, [&](const Material& inner) {
      const bool clear =
          !inner.adapter &&
          (std::holds_alternative<DielectricBsdf>(inner.bsdf) ||
           std::holds_alternative<RoughDielectricBsdf>(inner.bsdf) ||
           std::holds_alternative<ThinDielectricBsdf>(inner.bsdf) ||
           (std::holds_alternative<PrincipledBsdf>(inner.bsdf) && may_refract(std::get<PrincipledBsdf>(inner.bsdf))) ||
           (std::holds_alternative<GltfBsdf>(inner.bsdf) && may_refract(std::get<GltfBsdf>(inner.bsdf))) ||
           std::holds_alternative<PrincipledThinBsdf>(inner.bsdf) || std::holds_alternative<NullBsdf>(inner.bsdf));
      if (!clear && !(inner.adapter && std::holds_alternative<MaskAdapter>(*inner.adapter))) return;
      error(two_sided.position, "twosided",
            fmt::format("{} transmits light, so it has no back of its own; take it out of the twosided material, or "
                        "put that inside it",
                        text::quoted(inner.name)));
    });
  }

  void check_totals() {
    std::size_t triangles = 0, vertices = 0;
    for (const Shape& shape : scene_.shapes) {
      if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
        triangles += mesh->triangles.size();
        vertices += mesh->positions.size();
      }
    }
    if (triangles > kMaxTriangles || vertices > kMaxVertices)
      sink_.error(
          scene_.position,
          fmt::format("the scene has {} triangles and {} vertices; at most {} and {} are supported: use coarser "
                      "meshes",
                      triangles, vertices, kMaxTriangles, kMaxVertices));
  }

  /// Indices within their tables: whatever follows relies on it.
  bool tables_fit() {
    bool fit = true;
    const auto within = [&](std::size_t index, std::size_t size, const char* table, const Instance& instance) {
      if (index < size) return;
      fit = false;
      sink_.error(instance.position, fmt::format("{} refers to number {} of the scene's {}, of which there are {}",
                                                 text::quoted(instance.name), index, table, size));
    };
    for (std::uint32_t row = 0; row < scene_.materials.size(); ++row) {
      const Material& material = scene_.materials[row];
      if (!material.adapter) continue;
      each_choice(*material.adapter, [&](std::uint32_t choice) {
        if (choice < row) return;
        fit = false;
        sink_.error(
            material.position,
            fmt::format(
                "{}, number {} of the scene's materials, refers to number {}; it can refer only to earlier ones",
                text::quoted(material.name), row, choice));
      });
    }
    for (const Instance& instance : scene_.instances) {
      within(instance.shape, scene_.shapes.size(), "shapes", instance);
      within(instance.material, scene_.materials.size(), "materials", instance);
      if (instance.emitter) within(*instance.emitter, scene_.emitters.size(), "emitters", instance);
    }
    return fit;
  }

  void check_instance(const Instance& instance) {
    if (!is_usable(instance.world_from_object)) {
      error(instance.position, "world_from_object",
            fmt::format("the transform of {} is not affine, finite and invertible", text::quoted(instance.name)));
      return;
    }
    const Shape& shape = scene_.shape_of(instance);
    if (const auto* sphere = std::get_if<Sphere>(&shape)) return check_sphere(*sphere, instance);
    if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return check_cylinder(*cylinder, instance);
    if (std::holds_alternative<Disk>(shape)) return check_disk(instance);
    check_mesh(std::get<TriangleMesh>(shape), instance);
  }

  void check_disk(const Instance& instance) {
    check_box(instance, "disk");
    const double area = placed_disk(instance).area();
    if (instance.emitter && !(area > 0.0))
      sink_.error(scene_.emitter_of(instance)->position,
                  fmt::format("the emitter's disk {} has no area; it cannot send light", text::quoted(instance.name)));
  }

  void check_cylinder(const Cylinder& cylinder, const Instance& instance) {
    if (!(cylinder.radius > 0.0 && std::isfinite(cylinder.radius)) || !is_finite(cylinder.p0) ||
        !is_finite(cylinder.p1)) {
      return error(instance.position, "radius",
                   fmt::format("the cylinder {} has radius {}; it must be above 0, and its ends finite",
                               text::quoted(instance.name), cylinder.radius));
    }
    if (!is_similarity(instance.world_from_object)) {
      return error(instance.position, "world_from_object",
                   fmt::format("the transform of the cylinder {} scales it unevenly or shears it; use rotation, "
                               "translation and uniform scale, or a mesh",
                               text::quoted(instance.name)));
    }
    const PlacedCylinder placed = placed_cylinder(cylinder, instance);
    if (!(glm::distance(placed.p0, placed.p1) > 0.0) || !(placed.radius > 0.0)) {
      return error(instance.position, "p1",
                   fmt::format("the cylinder {} has no height: p0 and p1 are both {} {} {}; move one of them",
                               text::quoted(instance.name), cylinder.p0.x, cylinder.p0.y, cylinder.p0.z));
    }
    check_box(instance, "cylinder");
  }

  void check_box(const Instance& instance, const char* what) {
    const Bounds box = bounds_of(scene_, instance);
    const double largest = std::max(largest_coordinate(box.min), largest_coordinate(box.max));
    if (is_finite(box.min) && is_finite(box.max) && largest <= kMaxCoordinate) return;
    error(instance.position, "world_from_object",
          fmt::format("the {} {} reaches from {} {} {} to {} {} {}; coordinates up to {} are supported", what,
                      text::quoted(instance.name), box.min.x, box.min.y, box.min.z, box.max.x, box.max.y, box.max.z,
                      kMaxCoordinate));
  }

  void check_sphere(const Sphere& sphere, const Instance& instance) {
    if (!is_similarity(instance.world_from_object)) {
      return error(instance.position, "world_from_object",
                   fmt::format("the transform of the sphere {} scales it unevenly or shears it; use rotation, "
                               "translation and uniform scale, or a mesh",
                               text::quoted(instance.name)));
    }
    const Sphere placed = placed_sphere(sphere, instance);
    if (!(placed.radius > 0.0) || !is_finite(placed.center) ||
        !(largest_coordinate(placed.center) + placed.radius <= 4.0 * kMaxCoordinate)) {
      error(instance.position, "radius",
            fmt::format("the sphere has its centre at {} {} {} and radius {}; coordinates up to {} are supported",
                        placed.center.x, placed.center.y, placed.center.z, placed.radius, kMaxCoordinate));
    }
  }

  /// Facts about a mesh, determined once for all its instances.
  struct MeshChecks {
    bool checked = false, usable = false;
    Bounds box;
  };

  /// Attributes and indices of a mesh, reported for the first instance that shows it.
  const MeshChecks& check_shape(const TriangleMesh& mesh, const Instance& instance) {
    MeshChecks& checks = shapes_[instance.shape];
    if (std::exchange(checks.checked, true)) return checks;
    checks.usable = check_tables(mesh, instance);
    // A box cannot reveal NaN, so in that case every instance is checked vertex by vertex.
    if (std::ranges::all_of(mesh.positions, [](const glm::dvec3& p) { return is_finite(p); })) {
      checks.box = bounds_of(scene_.shape_of(instance));
    } else {
      checks.box.add(glm::dvec3(std::numeric_limits<double>::infinity()));
    }
    return checks;
  }

  /// False where a triangle cannot be looked at.
  bool check_tables(const TriangleMesh& mesh, const Instance& instance) {
    const std::size_t vertices = mesh.positions.size();
    const bool lengths_fit =
        (mesh.normals.empty() || mesh.normals.size() == vertices) &&
        (mesh.vertex_colors.empty() || mesh.vertex_colors.size() == vertices) &&
        (mesh.tangents.empty() || mesh.tangents.size() == vertices) &&
        (mesh.vertex_alphas.empty() || mesh.vertex_alphas.size() == vertices) &&
        (mesh.face_colors.empty() || mesh.face_colors.size() == mesh.triangles.size()) &&
        std::all_of(mesh.uv_sets.begin(), mesh.uv_sets.end(), [&](const auto& uvs) { return uvs.size() == vertices; });
    if (!lengths_fit) {
      sink_.error(instance.position,
                  fmt::format("an attribute of the mesh {} does not have an entry for each of its {} vertices, or of "
                              "its {} triangles",
                              text::quoted(instance.name), vertices, mesh.triangles.size()));
    }
    for (const glm::uvec3& t : mesh.triangles) {
      if (std::max({t.x, t.y, t.z}) < vertices) continue;
      sink_.error(instance.position, fmt::format("a triangle of the mesh {} refers to vertex {}; it has {}",
                                                 text::quoted(instance.name), std::max({t.x, t.y, t.z}), vertices));
      return false;
    }
    return true;
  }

  /// Half of the allowed range: if a box around all vertices is within it, they need not be checked.
  static bool lies_within(const Bounds& box) {
    constexpr double kRoom = 0.5;
    const double largest = std::max(largest_coordinate(box.min), largest_coordinate(box.max));
    return box.empty() || (is_finite(box.min) && is_finite(box.max) && largest <= kRoom * kMaxCoordinate);
  }

  void check_mesh(const TriangleMesh& mesh, const Instance& instance) {
    const MeshChecks& checks = check_shape(mesh, instance);
    if (!checks.usable) return;
    check_vertices(mesh, checks, instance);
    if (instance.emitter) check_area(mesh, instance);
  }

  void check_vertices(const TriangleMesh& mesh, const MeshChecks& checks, const Instance& instance) {
    if (lies_within(transformed(checks.box, instance.world_from_object))) return;
    const PlacedMesh placed(mesh, instance);
    for (std::uint32_t i = 0; i < mesh.positions.size(); ++i) {
      const glm::dvec3 p = placed.position(i);
      if (largest_coordinate(p) <= kMaxCoordinate) continue;
      error(instance.position, "world_from_object",
            fmt::format("a vertex of {} is at {} {} {} in world space; coordinates up to {} are supported",
                        text::quoted(instance.name), p.x, p.y, p.z, kMaxCoordinate));
      return;
    }
  }

  void check_area(const TriangleMesh& mesh, const Instance& instance) {
    const PlacedMesh placed(mesh, instance);
    for (std::size_t i = 0; i < placed.triangle_count(); ++i) {
      if (triangle_area(placed.triangle(i)) > 0.0) return;
    }
    sink_.error(scene_.emitter_of(instance)->position,
                fmt::format("the emitter's mesh {} has no area; it cannot send light", text::quoted(instance.name)));
  }

  const Scene& scene_;
  Diagnostics& sink_;
  const LocateField& locate_;
  std::vector<MeshChecks> shapes_;
};

}  // namespace

void check_invariants(const Scene& scene, Diagnostics& diagnostics, const LocateField& locate) {
  Checker(scene, diagnostics, locate).check();
}

void check_materials(const std::vector<Material>& materials, Diagnostics& diagnostics, const LocateField& locate) {
  Scene scene;
  scene.materials = materials;
  Checker(scene, diagnostics, locate).check_materials();
}

void check_lights(const LightSources& lights, Diagnostics& diagnostics) {
  Scene scene;
  set_light_sources(scene, lights);
  scene.position = lights.position;
  Checker(scene, diagnostics, {}).check_lights();
}

void require_invariants(const Scene& scene) {
  Diagnostics diagnostics;
  check_invariants(scene, diagnostics);
  diagnostics.throw_first_error();
}

}  // namespace etendue
