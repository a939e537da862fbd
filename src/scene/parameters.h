#pragma once
/// The parameters of materials and emitters that may be textured, so that code that needs all of them (hashing,
/// invariants, evaluation at a point) does not depend on the types.

#include <concepts>
#include <limits>
#include <string_view>
#include <type_traits>
#include <variant>

#include "scene/limits.h"
#include "scene/scene.h"

namespace etendue {

template <typename T, typename Struct>
concept MaybeConst = std::same_as<std::remove_const_t<T>, Struct>;

/// Calls f(name, parameter) for each ColorParameter and ScalarParameter, in the order of the struct; `name` is the
/// field's in scene.h. A material without any says so, too: there is no default.
template <MaybeConst<DiffuseBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  f("albedo", bsdf.albedo);
}
template <typename T, typename F>
requires MaybeConst<T, MirrorBsdf> || MaybeConst<T, NullBsdf> || MaybeConst<T, TwoSidedAdapter>
void each_parameter(T&, F&&) {}
template <MaybeConst<Roughness> T, typename F>
void each_parameter(T& roughness, F&& f) {
  f("alpha_u", roughness.alpha_u);
  f("alpha_v", roughness.alpha_v);
}
template <MaybeConst<MicrofacetBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  f("kd", bsdf.kd);
  f("alpha", bsdf.alpha);
}
template <MaybeConst<ConductorIndex> T, typename F>
void each_parameter(T& index, F&& f) {
  f("eta", index.eta);
  f("k", index.k);
}
template <MaybeConst<ConductorBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  each_parameter(bsdf.index, f);
  f("specular_reflectance", bsdf.specular_reflectance);
}
template <MaybeConst<RoughConductorBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  each_parameter(bsdf.index, f);
  f("specular_reflectance", bsdf.specular_reflectance);
  each_parameter(bsdf.roughness, f);
}
template <typename T, typename F>
requires MaybeConst<T, DielectricBsdf> || MaybeConst<T, RoughDielectricBsdf> || MaybeConst<T, ThinDielectricBsdf>
void each_parameter(T& bsdf, F&& f) {
  f("specular_reflectance", bsdf.specular_reflectance);
  f("specular_transmittance", bsdf.specular_transmittance);
  if constexpr (MaybeConst<T, RoughDielectricBsdf>) each_parameter(bsdf.roughness, f);
}
template <typename T, typename F>
requires MaybeConst<T, PlasticBsdf> || MaybeConst<T, RoughPlasticBsdf>
void each_parameter(T& bsdf, F&& f) {
  f("diffuse_reflectance", bsdf.diffuse_reflectance);
  f("specular_reflectance", bsdf.specular_reflectance);
  if constexpr (MaybeConst<T, RoughPlasticBsdf>) f("alpha", bsdf.alpha);
}
template <typename T, typename F>
requires MaybeConst<T, PrincipledBsdf> || MaybeConst<T, PrincipledThinBsdf>
void each_parameter(T& bsdf, F&& f) {
  constexpr bool kSolid = MaybeConst<T, PrincipledBsdf>;
  f("base_color", bsdf.base_color);
  f("roughness", bsdf.roughness);
  if constexpr (kSolid) f("metallic", bsdf.metallic);
  f("anisotropic", bsdf.anisotropic);
  f("spec_trans", bsdf.spec_trans);
  f("spec_tint", bsdf.spec_tint);
  f("sheen", bsdf.sheen);
  if constexpr (kSolid) f("clearcoat", bsdf.clearcoat);
  f("sheen_tint", bsdf.sheen_tint);
  f("flatness", bsdf.flatness);
  if constexpr (kSolid) f("clearcoat_gloss", bsdf.clearcoat_gloss);
  if constexpr (!kSolid) f("diff_trans", bsdf.diff_trans);
  f("eta", bsdf.eta);
}
template <MaybeConst<GltfBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  f("base_color", bsdf.base_color);
  f("metallic", bsdf.metallic);
  f("roughness", bsdf.roughness);
  f("ior", bsdf.ior);
  f("specular", bsdf.specular);
  f("specular_color", bsdf.specular_color);
  f("transmission", bsdf.transmission);
  f("diffuse_transmission", bsdf.diffuse_transmission);
  f("diffuse_transmission_color", bsdf.diffuse_transmission_color);
  f("clearcoat", bsdf.clearcoat);
  f("clearcoat_roughness", bsdf.clearcoat_roughness);
  f("sheen_color", bsdf.sheen_color);
  f("sheen_roughness", bsdf.sheen_roughness);
  f("anisotropy", bsdf.anisotropy);
  if (bsdf.anisotropy_directions.texture) f("anisotropy_directions", bsdf.anisotropy_directions);
  f("iridescence", bsdf.iridescence);
  f("iridescence_ior", bsdf.iridescence_ior);
  f("iridescence_thickness", bsdf.iridescence_thickness);
  if (bsdf.coat_normals.texture) f("coat_normals", bsdf.coat_normals);
}
template <MaybeConst<Bsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  std::visit([&](auto& of_type) { each_parameter(of_type, f); }, bsdf);
}
template <MaybeConst<MaskAdapter> T, typename F>
void each_parameter(T& mask, F&& f) {
  f("opacity", mask.opacity);
}
template <MaybeConst<BlendAdapter> T, typename F>
void each_parameter(T& blend, F&& f) {
  f("weight", blend.weight);
}
template <MaybeConst<NormalMapAdapter> T, typename F>
void each_parameter(T& map, F&& f) {
  f("normals", map.normals);
}
template <MaybeConst<BumpMapAdapter> T, typename F>
void each_parameter(T& map, F&& f) {
  f("height", map.height);
}
template <MaybeConst<Adapter> T, typename F>
void each_parameter(T& adapter, F&& f) {
  std::visit([&](auto& of_type) { each_parameter(of_type, f); }, adapter);
}
/// Only for its own row.
template <MaybeConst<Material> T, typename F>
void each_parameter(T& material, F&& f) {
  if (material.adapter) {
    each_parameter(*material.adapter, f);
  } else {
    each_parameter(material.bsdf, f);
  }
}
/// The same, and the numbers and colours that no texture can stand for.
template <MaybeConst<Material> T, typename F>
void each_number(T& material, F&& f) {
  each_parameter(material, f);
  if (material.adapter) return;
  std::visit(
      [&](auto& bsdf) {
        if constexpr (requires { bsdf.int_ior; }) {
          f("int_ior", bsdf.int_ior);
          f("ext_ior", bsdf.ext_ior);
        }
        if constexpr (MaybeConst<std::remove_reference_t<decltype(bsdf)>, GltfBsdf>) {
          f("anisotropy_rotation", bsdf.anisotropy_rotation);
          f("dispersion", bsdf.dispersion);
          f("attenuation_color", bsdf.attenuation_color);
          f("attenuation_distance", bsdf.attenuation_distance);
        }
      },
      material.bsdf);
}
template <MaybeConst<AreaEmitter> T, typename F>
void each_parameter(T& emitter, F&& f) {
  f("radiance", emitter.radiance);
}
template <MaybeConst<DeltaLight> T, typename F>
void each_parameter(T& light, F&& f) {
  f("intensity", light.intensity);
}

/// The range that textured values are clamped to: that of constants, or the meaningful part of it.
struct ParameterRange {
  double least, most;
};
/// The range of a parameter by its name in each_parameter(). Only the albedo of diffuse materials is not clamped.
template <typename T>
constexpr ParameterRange parameter_range(const T&, std::string_view name) {
  if (name == "coat_normals" || name == "anisotropy_directions")
    return {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max()};  // directions
  constexpr bool kMetal = std::is_same_v<T, ConductorBsdf> || std::is_same_v<T, RoughConductorBsdf>;
  if (std::is_same_v<T, DiffuseBsdf>) return {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max()};
  if (name.starts_with("alpha")) return {kMinRoughness, 1.0};
  if (kMetal && (name == "eta" || name == "k")) return {0.0, kMaxConductorIndex};
  if (name == "diff_trans") return {0.0, 2.0};
  if (name == "ior") return {1.0, kMaxTexturedIndex};
  if (name == "specular_color") return {0.0, kMaxSpecularColor};
  if (name == "iridescence_ior") return {1.0, kMaxFilmIndex};
  if (name == "iridescence_thickness") return {0.0, kMaxFilmThickness};
  if (name == "eta") return {1.0 + kMinIndexContrast, kMaxTexturedIndex};
  return {0.0, 1.0};
}

/// Whether any parameter has a texture.
template <typename T>
bool is_textured(const T& owner) {
  bool textured = false;
  each_parameter(owner, [&](const char*, const auto& parameter) { textured |= parameter.texture.has_value(); });
  return textured;
}

}  // namespace etendue
