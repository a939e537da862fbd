#pragma once
/// Adapters between a surface and its materials; docs/conventions.md, "Adapters".

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
  /// The normal before maps turned it, on the same side; nothing if no map did.
  std::optional<Vec3> base = {};
  double side = 1.0;     ///< of the frame's normal, against that of the surface
  bool shadowed = true;  ///< whether the turned normal shadows
};

/// A chosen material, and the alternative that the outermost blend on the way did not choose.
struct ChosenMaterials {
  ChosenMaterial chosen;
  double share = 1.0;                        ///< the probability of that blend's choice
  std::optional<std::uint32_t> blend = {};   ///< its row
  std::optional<ChosenMaterial> other = {};  ///< nothing if there is no blend, or if light would pass
};

/// Decides for adapters that choose by chance.
class Decider {
 public:
  /// Whether an event of this probability happens to the adapter in a row of the table.
  virtual bool happens(std::uint32_t row, double probability) = 0;

 protected:
  ~Decider() = default;
};

/// By the random numbers of a path that has met a surface in direction `d` at vertex `k`, or of a shadow ray from
/// there.
class RandomDecider final : public Decider {
 public:
  RandomDecider(const Surface& surface, const Vec3& d, const SampleRandom& random, std::uint32_t k, bool shadow_ray)
      : random_(random), decision_{k, surface.instance, surface.primitive, glm::dot(d, surface.ng) > 0.0, shadow_ray} {}
  bool happens(std::uint32_t row, double probability) override { return random_.choice(decision_, row) < probability; }

 private:
  const SampleRandom& random_;
  SampleRandom::Decision decision_;
};

/// The material where a ray in direction `d` has hit a surface: at vertex `k`, or at a hit of a shadow ray from there.
/// Nothing if the ray passes.
std::optional<ChosenMaterial> choose_material(const Scene& scene, const Surface& surface, const Vec3& d,
                                              const SampleRandom& random, std::uint32_t k, bool shadow_ray);
/// The same, with the alternative that a blend did not choose.
std::optional<ChosenMaterials> choose_materials(const Scene& scene, const Surface& surface, const Vec3& d,
                                                Decider& decider);
/// The same for a path that arrives at vertex `k`.
std::optional<ChosenMaterials> choose_materials(const Scene& scene, const Surface& surface, const Vec3& d,
                                                const SampleRandom& random, std::uint32_t k);

/// A chosen material at a point hit by a ray in direction `d`: all its parameters are constants.
Bsdf material_at(const Scene& scene, const ChosenMaterial& chosen, const Surface& surface, const Vec3& d);

}  // namespace etendue::reference
