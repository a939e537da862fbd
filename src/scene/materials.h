#pragma once
/// The table of materials seen from one of its rows: an adapter's choices lie before it.

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

/// Whether some of the light that meets it is refracted.
inline bool may_refract(const PrincipledBsdf& bsdf) {
  const bool metal = !bsdf.metallic.texture && bsdf.metallic.value == 1.0;
  return !metal && (bsdf.spec_trans.texture || bsdf.spec_trans.value > 0.0);
}

/// Whether light may pass a surface of this material as if there were nothing.
bool may_pass(const Scene& scene, std::uint32_t row);
/// The same of any instance of the scene.
bool may_pass(const Scene& scene);

}  // namespace etendue
