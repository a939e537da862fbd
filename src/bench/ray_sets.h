#pragma once
/// The rays that are measured: those of a picture, by class and in two orders.

#include <string>
#include <vector>

#include "render/ray_caster.h"

namespace etendue {

/// Rays of one class in one order. In picture order neighbours in the set are neighbours in an 8 × 8 tile of the
/// picture (coherent); shuffled they have nothing in common.
struct RaySet {
  std::string kind;  ///< "primary", "diffuse" or "shadow"
  bool shuffled = false;
  RayQuery query = RayQuery::closest;
  std::vector<CastRay> rays;
  std::string name() const { return shuffled ? kind + ", shuffled" : kind; }
};

struct RaySetOptions {
  std::size_t count = 1 << 19;  ///< primary rays, about
  std::uint64_t seed = 0;
};

/// Primary: through the centres of the pixels of a film of the scene's aspect ratio. Diffuse: one cosine-distributed
/// bounce from the nearest hit of each, on the side the ray came from, whatever the material. Shadow: from the same
/// hits to points distributed uniformly over the area of all emitters, or over the box of all vertices where there are
/// none; rays in the plane of one of their ends are left out. Each class is there twice, in picture order and shuffled;
/// classes without rays are left out. `caster` finds the hits.
std::vector<RaySet> make_ray_sets(const Scene& scene, RayCaster& caster, const RaySetOptions& options);

}  // namespace etendue
