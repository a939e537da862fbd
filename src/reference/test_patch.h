#pragma once
/// The point of a patch (scene/test_patch.h) at which its material is tested.

#include "reference/adapters.h"
#include "reference/ray.h"
#include "reference/texture.h"
#include "scene/materials.h"

namespace etendue::reference {

inline Surface patch_surface() {
  Surface surface;
  surface.ng = surface.ns = Vec3(0.0, 0.0, 1.0);
  surface.weights = Vec3(1.0, 0.0, 0.0);
  return surface;
}

/// The patch's material, which is no adapter, as it is chosen there.
inline ChosenMaterial plain_material(const Scene& patch, const Surface& surface) {
  const std::uint32_t row = patch.instances.front().material;
  const Frame frame(surface.ns);
  return {row, is_aligned(patch.materials[row]) ? frame.along(tangents(patch, 0, surface).u) : frame};
}

}  // namespace etendue::reference
