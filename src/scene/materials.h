#pragma once
/// The table of materials seen from one of its rows: an adapter's choices come before it.

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace etendue {

/// Calls f(material) for a row and everything it may choose, each once.
template <typename F>
void each_material(const Scene& scene, std::uint32_t row, F&& f) {
  if (!scene.materials[row].adapter) return f(scene.materials[row]);
  std::vector<bool> seen(row + 1, false);
  seen[row] = true;
  for (std::uint32_t i = row + 1; i-- > 0;) {
    if (!seen[i]) continue;
    f(scene.materials[i]);
    if (scene.materials[i].adapter)
      each_choice(*scene.materials[i].adapter, [&](std::uint32_t choice) { seen[choice] = true; });
  }
}

inline bool is_aligned(const Roughness& roughness) {
  const ScalarParameter &u = roughness.alpha_u, &v = roughness.alpha_v;
  return u.value != v.value || u.texture != v.texture || (u.texture && u.channel != v.channel);
}
/// Whether a material looks different when its surface is rotated about the normal: its frame follows the first texture
/// coordinates of the surface.
template <typename T>
bool is_aligned(const T& bsdf) {
  if constexpr (requires { bsdf.roughness.alpha_u; }) return is_aligned(bsdf.roughness);
  if constexpr (requires { bsdf.anisotropic; }) return bsdf.anisotropic.value != 0.0;
  if constexpr (requires { bsdf.anisotropy; }) return bsdf.anisotropy.value != 0.0;
  return false;
}
inline bool is_aligned(const Material& material) {
  return !material.adapter && std::visit([](const auto& bsdf) { return is_aligned(bsdf); }, material.bsdf);
}

/// Whether it reflects and transmits less than everything.
inline bool is_tinted(const DielectricBsdf& bsdf) {
  const auto white = [](const ColorParameter& c) { return !c.texture && c.value == glm::dvec3(1.0); };
  return !white(bsdf.specular_reflectance) || !white(bsdf.specular_transmittance);
}

/// Whether it refracts some of the light.
inline bool may_refract(const PrincipledBsdf& bsdf) {
  const bool metal = !bsdf.metallic.texture && bsdf.metallic.value == 1.0;
  return !metal && (bsdf.spec_trans.texture || bsdf.spec_trans.value > 0.0);
}

/// The same for a sheet, which transmits light without refraction, or scattered.
inline bool may_refract(const PrincipledThinBsdf&) {
  return true;
}
inline bool may_refract(const GltfBsdf& bsdf) {
  const auto some = [](const ScalarParameter& share) { return share.texture || share.value > 0.0; };
  const bool metal = !bsdf.metallic.texture && bsdf.metallic.value == 1.0;
  return !metal && (some(bsdf.transmission) || some(bsdf.diffuse_transmission));
}

/// Whether it refracts each colour differently.
inline bool disperses(const GltfBsdf& bsdf) {
  return bsdf.dispersion > 0.0 && !bsdf.thin && may_refract(bsdf);
}

/// Whether light may pass a surface of this material unchanged.
bool may_pass(const Scene& scene, std::uint32_t row);
/// The same for any instance of the scene.
bool may_pass(const Scene& scene);

}  // namespace etendue
