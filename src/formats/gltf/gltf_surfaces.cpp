#include "formats/gltf/gltf_surfaces.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "scene/limits.h"
#include "scene/materials.h"

namespace etendue {
namespace {

/// Whether alpha makes parts of the surface invisible.
bool has_opacity(const GltfMaterial& m) {
  return m.alpha != GltfMaterial::Alpha::opaque;
}

/// The texture's alpha from which the material is visible. Outside [0,1], all or nothing is visible.
double cutoff_of_texture(const GltfMaterial& m) {
  return std::clamp(m.alpha_cutoff / m.base_color.a, -1.0, 2.0);
}

/// The share of a surface's light that its alpha factor lets it emit.
double share_of_alpha(const GltfMaterial& m) {
  const double alpha = m.base_color.a;
  return m.alpha == GltfMaterial::Alpha::mask ? (alpha >= m.alpha_cutoff ? 1.0 : 0.0) : alpha;
}

/// The textures that become parameters of the scene's material.
std::vector<const MaybeTexture*> textures_of(const GltfMaterial& m) {
  return {&m.base_color_texture,
          &m.metallic_roughness_texture,
          &m.specular_glossiness_texture,
          &m.normal_texture,
          &m.emission_texture,
          &m.clearcoat_texture,
          &m.clearcoat_roughness_texture,
          &m.clearcoat_normal_texture,
          &m.sheen_color_texture,
          &m.sheen_roughness_texture,
          &m.specular_texture,
          &m.specular_color_texture,
          &m.transmission_texture,
          &m.anisotropy_texture,
          &m.iridescence_texture,
          &m.iridescence_thickness_texture,
          &m.diffuse_transmission_texture,
          &m.diffuse_transmission_color_texture};
}

}  // namespace

const GltfMaterial& GltfSurfaces::material(std::optional<std::uint32_t> index, const JsonValue& where) {
  const auto known = materials_.find(index);
  if (known != materials_.end()) return known->second;
  GltfMaterial m = default_gltf_material();
  if (index) {
    try {
      m = parse_gltf_material(document_.element("materials", *index, where));
    } catch (const GltfError& error) {
      sink_.error(document_.position(*error.where), error.message, error.kind);
    }
    if (m.name.empty()) m.name = fmt::format("material {}", *index);
  }
  return materials_.emplace(index, std::move(m)).first->second;
}

PrimitiveNeeds GltfSurfaces::needs(std::optional<std::uint32_t> index, const PrimitiveContent& content,
                                   const JsonValue& where) {
  const GltfMaterial& m = material(index, where);
  PrimitiveNeeds needs;
  for (const MaybeTexture* info : textures_of(m)) {
    if (*info && (*info)->uv_set < content.uv_sets) needs.uv_sets = std::max(needs.uv_sets, (*info)->uv_set + 1);
  }
  needs.colors = content.colors;
  needs.alphas = content.colors_have_alpha && has_opacity(m);
  if (m.anisotropy > 0.0 && content.uv_sets > 0) {
    needs.uv_sets = std::max(needs.uv_sets, 1u);
    if (m.anisotropy_rotation != 0.0 || m.anisotropy_texture) needs.tangent_uv = 0;
  }
  // A mesh has tangents for one set of texture coordinates only.
  for (const MaybeTexture* map : {&m.clearcoat_normal_texture, &m.normal_texture}) {
    if (*map && (*map)->uv_set < content.uv_sets)
      (content.normals ? needs.tangents : needs.tangent_uv) = (*map)->uv_set;
  }
  return needs;
}

GltfSurface GltfSurfaces::surface(std::optional<std::uint32_t> index, const PrimitiveContent& content, bool mirrored,
                                  const JsonValue& where) {
  const Traits traits{content.uv_sets, content.colors, content.colors_have_alpha, mirrored, content.normals};
  const auto [known, is_new] = surfaces_.try_emplace({index, traits});
  if (is_new) known->second = make(material(index, where), traits);
  return known->second;
}

GltfSurface GltfSurfaces::make(const GltfMaterial& m, const Traits& traits) {
  say_what_is_left_out(m);
  Bsdf bsdf = bsdf_of(m, traits);
  const auto* layered = std::get_if<GltfBsdf>(&bsdf);
  const bool refracts = layered != nullptr && may_refract(*layered);
  std::uint32_t row = add({.bsdf = std::move(bsdf)}, m);
  row = with_normals(m, traits, row);
  // Both sides are shown, even without doubleSided: viewers cull back faces, but light cannot.
  if (!refracts) row = add({.adapter = TwoSidedAdapter{row, row}}, m);
  row = with_opacity(m, traits, row);
  return {row, emitter_of(m, traits)};
}

Bsdf GltfSurfaces::bsdf_of(const GltfMaterial& m, const Traits& traits) {
  if (m.model == GltfMaterial::Model::unlit) return DiffuseBsdf{glm::dvec3(0.0)};
  GltfBsdf b;
  b.base_color = base_color(m, traits);
  if (m.model == GltfMaterial::Model::specular_glossiness) {
    set_specular_glossiness(m, traits, b);
    return b;
  }
  assign(b.metallic, m.metallic, m.metallic_roughness_texture, traits, TextureChannel::blue);
  assign(b.roughness, m.roughness, m.metallic_roughness_texture, traits, TextureChannel::green);
  // 0 stands for an infinite index.
  b.ior = m.ior == 0.0 ? kMaxTexturedIndex : std::clamp(m.ior, 1.0, kMaxTexturedIndex);
  assign(b.specular, m.specular, m.specular_texture, traits, TextureChannel::alpha);
  assign(b.specular_color, glm::min(m.specular_color, kMaxSpecularColor), m.specular_color_texture, traits);
  set_layers(m, traits, b);
  set_transmission(m, traits, b);
  return b;
}

/// The extension's specular colour is the reflectance at normal incidence; here it becomes a factor on that of the
/// index 1.5. As in the extension, the diffuse part is scaled by 1 minus its largest component.
void GltfSurfaces::set_specular_glossiness(const GltfMaterial& m, const Traits& traits, GltfBsdf& b) {
  constexpr double kReflectanceOfIndex = 0.04;
  const TextureRecipe recipe = roughness_of_glossiness(m.glossiness);
  b.metallic = 0.0;
  b.roughness = 1.0 - m.glossiness;
  if (m.specular_glossiness_texture) {
    assign(b.roughness, 1.0, m.specular_glossiness_texture, traits, TextureChannel::red, &recipe);
  } else {
    const glm::dvec3& f = m.specular_factor;
    b.base_color.value *= 1.0 - std::max({f.x, f.y, f.z});
  }
  assign(b.specular_color, m.specular_factor / kReflectanceOfIndex, m.specular_glossiness_texture, traits);
}

void GltfSurfaces::set_layers(const GltfMaterial& m, const Traits& traits, GltfBsdf& b) {
  assign(b.clearcoat, m.clearcoat, m.clearcoat_texture, traits, TextureChannel::red);
  assign(b.clearcoat_roughness, m.clearcoat_roughness, m.clearcoat_roughness_texture, traits, TextureChannel::green);
  assign(b.sheen_color, m.sheen_color, m.sheen_color_texture, traits);
  assign(b.sheen_roughness, m.sheen_roughness, m.sheen_roughness_texture, traits, TextureChannel::alpha);
  assign(b.anisotropy, m.anisotropy, m.anisotropy_texture, traits, TextureChannel::blue);
  // A coat without its own normal texture is smooth, even if the base has one.
  b.coat_keeps_normal = m.clearcoat > 0.0 && (m.normal_texture || m.clearcoat_normal_texture);
  if (b.coat_keeps_normal && m.clearcoat_normal_texture) {
    b.coat_normals.texture = normal_row(m.clearcoat_normal_texture, m.clearcoat_normal_scale, traits);
    b.coat_vertex_tangents = traits.normals;
  }
  // The angle is measured from the tangent toward the bitangent, which points the other way if coordinates are
  // mirrored.
  b.anisotropy_rotation = traits.mirrored ? -m.anisotropy_rotation : m.anisotropy_rotation;
  if (m.anisotropy > 0.0 && m.anisotropy_texture) {
    const TextureRecipe flipped = scaled_normals(1.0, true);
    b.anisotropy_directions.texture =
        texture(m.anisotropy_texture, traits, ColorSpace::linear, traits.mirrored ? &flipped : nullptr);
  }
  assign(b.iridescence, m.iridescence, m.iridescence_texture, traits, TextureChannel::red);
  b.iridescence_ior = std::min(m.iridescence_ior, kMaxFilmIndex);
  const double most = std::min(std::max(m.iridescence_least, m.iridescence_most), kMaxFilmThickness);
  const TextureRecipe recipe = film_thickness(m.iridescence_least / most, m.iridescence_most / most);
  b.iridescence_thickness = std::min(m.iridescence_most, kMaxFilmThickness);
  if (most > 0.0 && m.iridescence > 0.0 && m.iridescence_thickness_texture)
    assign(b.iridescence_thickness, most, m.iridescence_thickness_texture, traits, TextureChannel::red, &recipe);
}

void GltfSurfaces::set_transmission(const GltfMaterial& m, const Traits& traits, GltfBsdf& b) {
  assign(b.transmission, m.transmission, m.transmission_texture, traits, TextureChannel::red);
  assign(b.diffuse_transmission, m.diffuse_transmission, m.diffuse_transmission_texture, traits, TextureChannel::alpha);
  assign(b.diffuse_transmission_color, m.diffuse_transmission_color, m.diffuse_transmission_color_texture, traits);
  b.thin = !m.is_volume();
  b.dispersion = b.thin ? 0.0 : std::min(m.dispersion, kMaxDispersion);
  if (b.thin || !(m.attenuation_distance > 0.0)) return;
  b.attenuation_color = glm::max(m.attenuation_color, kMinAttenuation);
  b.attenuation_distance = m.attenuation_distance;
}

ColorParameter GltfSurfaces::base_color(const GltfMaterial& m, const Traits& traits) {
  ColorParameter color;
  assign(color, glm::dvec3(m.base_color), m.base_color_texture, traits);
  if (traits.colors) color.texture = textures_.tinted(color.texture, position(m));
  return color;
}

std::optional<std::uint32_t> GltfSurfaces::normal_row(const MaybeTexture& info, double scale, const Traits& traits) {
  // Flat triangles get their frame from their own texture coordinates, smooth ones from the tangents of their vertices,
  // which already account for mirroring.
  const bool flip = traits.mirrored && !traits.normals;
  const TextureRecipe recipe = scaled_normals(scale, flip);
  return texture(info, traits, ColorSpace::linear, scale == 1.0 && !flip ? nullptr : &recipe);
}

std::uint32_t GltfSurfaces::with_normals(const GltfMaterial& m, const Traits& traits, std::uint32_t inner) {
  if (!m.normal_texture || m.model == GltfMaterial::Model::unlit) return inner;
  const auto row = normal_row(m.normal_texture, m.normal_scale, traits);
  if (!row) return inner;
  return add({.adapter = NormalMapAdapter{ColorParameter(glm::dvec3(1.0), *row), inner, traits.normals}}, m);
}

std::uint32_t GltfSurfaces::with_opacity(const GltfMaterial& m, const Traits& traits, std::uint32_t inner) {
  if (!has_opacity(m)) return inner;
  const bool blend = m.alpha == GltfMaterial::Alpha::blend;
  const double factor = m.base_color.a;
  if (traits.colors && traits.colors_have_alpha && factor > 0.0) {
    std::uint32_t row = *base_color(m, traits).texture;
    if (!blend) row = textures_.derived(row, cutoff_of_texture(m), false);
    return add({.adapter = MaskAdapter{{blend ? factor : 1.0, row, TextureChannel::alpha}, inner}}, m);
  }
  ScalarParameter opacity(blend ? factor : factor >= m.alpha_cutoff ? 1.0 : 0.0);
  if (m.base_color_texture && factor > 0.0) {
    // Sampled like the colours. MASK compares what is between the texels.
    std::optional<std::uint32_t> row = texture(m.base_color_texture, traits, ColorSpace::srgb);
    if (row && !blend) row = textures_.derived(*row, cutoff_of_texture(m), false);
    if (row) opacity = {blend ? factor : 1.0, *row, TextureChannel::alpha};
  }
  if (!opacity.texture && opacity.value == 1.0) return inner;
  return add({.adapter = MaskAdapter{opacity, inner}}, m);
}

bool GltfSurfaces::alpha_varies(const GltfMaterial& m, const Traits& traits) {
  return m.base_color.a > 0.0 && (m.base_color_texture || (traits.colors && traits.colors_have_alpha));
}

/// Multiplies the colours of an unlit surface with its alpha: a masked texel emits fully or not at all, a blended one
/// in proportion to its alpha.
void GltfSurfaces::premultiply(const GltfMaterial& m, const Traits& traits, ColorParameter& radiance) {
  const bool mask = m.alpha == GltfMaterial::Alpha::mask;
  if (!radiance.texture || !alpha_varies(m, traits)) {
    radiance.value *= share_of_alpha(m);
    return;
  }
  if (!mask) radiance.value *= m.base_color.a;
  if (mask || traits.colors) {
    radiance.texture =
        textures_.derived(*radiance.texture, mask ? std::optional(cutoff_of_texture(m)) : std::nullopt, true);
  } else {
    const TextureRecipe recipe = premultiplied();
    if (const auto row = texture(m.base_color_texture, traits, ColorSpace::srgb, &recipe)) radiance.texture = row;
  }
}

/// What is transparent does not glow.
void GltfSurfaces::dim_emission(const GltfMaterial& m, const Traits& traits, ColorParameter& radiance) {
  const bool mask = m.alpha == GltfMaterial::Alpha::mask;
  const bool of_vertices = traits.colors && traits.colors_have_alpha;
  if (!alpha_varies(m, traits)) {
    radiance.value *= share_of_alpha(m);
  } else if (!radiance.texture && !of_vertices) {
    const TextureRecipe recipe = mask ? white_with_alpha() : alpha_as_grey();
    radiance.texture = texture(m.base_color_texture, traits, ColorSpace::linear, &recipe);
    if (radiance.texture && mask) radiance.texture = textures_.derived(*radiance.texture, cutoff_of_texture(m), true);
    if (!mask) radiance.value *= m.base_color.a;
  } else {
    warn_once(m,
              "is transparent in places and glows there, too: its alpha and its emission, or that of its vertices, "
              "are not multiplied");
  }
}

std::optional<std::uint32_t> GltfSurfaces::emitter_of(const GltfMaterial& m, const Traits& traits) {
  AreaEmitter emitter{.position = position(m)};
  if (m.model == GltfMaterial::Model::unlit) {
    emitter.radiance = base_color(m, traits);
    if (has_opacity(m)) premultiply(m, traits, emitter.radiance);
  } else {
    assign(emitter.radiance, m.emission, m.emission_texture, traits);
    if (has_opacity(m) && emitter.radiance.value != glm::dvec3(0.0)) dim_emission(m, traits, emitter.radiance);
  }
  if (emitter.radiance.value == glm::dvec3(0.0)) return std::nullopt;
  emitter.two_sided = m.double_sided;
  scene_.emitters.push_back(emitter);
  return static_cast<std::uint32_t>(scene_.emitters.size() - 1);
}

void GltfSurfaces::say_what_is_left_out(const GltfMaterial& m) {
  const auto say = [&](bool used, const char* what) {
    if (used) warn_once(m, fmt::format("{}, which is not shown", what));
  };
  if (m.occlusion_texture && said_.insert("occlusion").second)
    sink_.note(position(m), "occlusion textures are ignored, because light is traced");
  say(m.scatters, "scatters light inside");
}

std::optional<std::uint32_t> GltfSurfaces::texture(const MaybeTexture& info, const Traits& traits,
                                                   ColorSpace color_space, const TextureRecipe* recipe) {
  if (!info) return std::nullopt;
  if (info->uv_set < traits.uv_sets) return textures_.row(*info, color_space, recipe);
  const std::string sentence =
      fmt::format("a mesh has no TEXCOORD_{}, which this texture needs: it is left out", info->uv_set);
  const SourcePosition at = document_.position(*info->where);
  if (said_.insert(to_string(at) + sentence).second) sink_.warning(at, sentence);
  return std::nullopt;
}

void GltfSurfaces::assign(ScalarParameter& parameter, double factor, const MaybeTexture& info, const Traits& traits,
                          TextureChannel channel, const TextureRecipe* recipe) {
  parameter = factor;
  if (factor == 0.0) return;
  if (const auto row = texture(info, traits, ColorSpace::linear, recipe)) parameter = {factor, *row, channel};
}

void GltfSurfaces::assign(ColorParameter& parameter, const glm::dvec3& factor, const MaybeTexture& info,
                          const Traits& traits) {
  parameter = factor;
  if (factor == glm::dvec3(0.0)) return;
  if (const auto row = texture(info, traits, ColorSpace::srgb)) parameter.texture = row;
}

std::uint32_t GltfSurfaces::add(Material row, const GltfMaterial& m) {
  row.name = m.name;
  row.position = position(m);
  scene_.materials.push_back(std::move(row));
  return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

SourcePosition GltfSurfaces::position(const GltfMaterial& m) const {
  return m.where == nullptr ? scene_.position : document_.position(*m.where);
}

void GltfSurfaces::warn_once(const GltfMaterial& m, const std::string& sentence) {
  const SourcePosition at = position(m);
  if (said_.insert(to_string(at) + sentence).second)
    sink_.warning(at, fmt::format("the material {} {}", text::quoted(m.name), sentence));
}

}  // namespace etendue
