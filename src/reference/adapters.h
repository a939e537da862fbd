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
  double side = 1.0;     ///< of the frame's normal, against that of the surface
  bool shadowed = true;  ///< by the normal that maps have turned
};

/// A material that was chosen, and what the outermost blend on the way to it would have chosen else.
struct ChosenMaterials {
  ChosenMaterial chosen;
  double share = 1.0;                        ///< the probability with which that blend chose as it did
  std::optional<ChosenMaterial> other = {};  ///< nothing where there is no blend, or where light would pass
};

/// The material that stands where a ray in direction `d` has met a surface: vertex `k`, or what a shadow ray from there
/// has met. Nothing where the ray passes.
std::optional<ChosenMaterial> choose_material(const Scene& scene, const Surface& surface, const Vec3& d,
                                              const SampleRandom& random, std::uint32_t k, bool shadow_ray);
/// The same with what a blend did not choose, for a path that arrives at vertex `k`.
std::optional<ChosenMaterials> choose_materials(const Scene& scene, const Surface& surface, const Vec3& d,
                                                const SampleRandom& random, std::uint32_t k);

/// A chosen material at a point that a ray in direction `d` has met: all of its parameters are constants.
Bsdf material_at(const Scene& scene, const ChosenMaterial& chosen, const Surface& surface, const Vec3& d);

}  // namespace etendue::reference
