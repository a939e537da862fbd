#pragma once
/// What stands between a surface and its materials; docs/conventions.md, "Adapters".

#include <cstdint>
#include <optional>

#include "reference/frame.h"
#include "reference/ray.h"
#include "reference/rng.h"
#include "scene/scene.h"

namespace etendue::reference {

/// A material that scatters, and the frame in which it sees directions.
struct ChosenMaterial {
  std::uint32_t row = 0;
  Frame frame;
  /// The normal before maps turned it, on the same side; nothing where none has.
  std::optional<Vec3> base = {};
};

/// The material that stands where a ray in direction `d` has met a surface: vertex `k`, or what a shadow ray from there
/// has met. Nothing where the ray passes.
std::optional<ChosenMaterial> choose_material(const Scene& scene, const Surface& surface, const Vec3& d,
                                              const SampleRandom& random, std::uint32_t k, bool shadow_ray);

}  // namespace etendue::reference
