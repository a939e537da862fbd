#pragma once
/// The parameters of materials and emitters that may be textured, so that whoever wants all of them need not know the
/// types: hashing, invariants, evaluation at a point.

#include <concepts>
#include <type_traits>
#include <variant>

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
requires MaybeConst<T, MirrorBsdf> || MaybeConst<T, DielectricBsdf> || MaybeConst<T, NullBsdf> ||
    MaybeConst<T, TwoSidedAdapter>
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
template <MaybeConst<ConductorBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  f("specular_reflectance", bsdf.specular_reflectance);
}
template <MaybeConst<RoughConductorBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  f("specular_reflectance", bsdf.specular_reflectance);
  each_parameter(bsdf.roughness, f);
}
template <typename T, typename F>
requires MaybeConst<T, RoughDielectricBsdf> || MaybeConst<T, ThinDielectricBsdf>
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
}
template <MaybeConst<PrincipledBsdf> T, typename F>
void each_parameter(T& bsdf, F&& f) {
  f("base_color", bsdf.base_color);
  f("roughness", bsdf.roughness);
  f("metallic", bsdf.metallic);
  f("anisotropic", bsdf.anisotropic);
  f("spec_trans", bsdf.spec_trans);
  f("spec_tint", bsdf.spec_tint);
  f("sheen", bsdf.sheen);
  f("clearcoat", bsdf.clearcoat);
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
/// Of its own row alone.
template <MaybeConst<Material> T, typename F>
void each_parameter(T& material, F&& f) {
  if (material.adapter) {
    each_parameter(*material.adapter, f);
  } else {
    each_parameter(material.bsdf, f);
  }
}
template <MaybeConst<AreaEmitter> T, typename F>
void each_parameter(T& emitter, F&& f) {
  f("radiance", emitter.radiance);
}
template <MaybeConst<DeltaLight> T, typename F>
void each_parameter(T& light, F&& f) {
  f("intensity", light.intensity);
}

/// Whether any parameter has a texture.
template <typename T>
bool is_textured(const T& owner) {
  bool textured = false;
  each_parameter(owner, [&](const char*, const auto& parameter) { textured |= parameter.texture.has_value(); });
  return textured;
}

}  // namespace etendue
