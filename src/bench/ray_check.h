#pragma once
/// What a caster answered against what the reference answers: a rate of wrong hits is worth nothing.

#include "bench/ray_sets.h"

namespace etendue {

struct RayCheck {
  std::size_t checked = 0;
  std::size_t hits = 0;      ///< of the checked rays, by the caster
  std::size_t differ = 0;    ///< one found a hit and the other none, or another distance
  std::size_t wrong = 0;     ///< of these, the ones that rounding does not explain
  double largest_error = 0;  ///< of the distance, relative, where both agree
  bool passed() const { return wrong == 0; }
};

/// Compares answers with those of `reference` for at most `most` of the rays, evenly spread. A ray past an edge or
/// along a surface may go either way in single precision: a difference is explained when the reference gives the
/// caster's answer to one of some rays that lie a few units in the last place beside, or answers on both sides of it.
RayCheck check_rays(const RaySet& set, const std::vector<CastHit>& hits, RayCaster& reference, std::size_t most);

}  // namespace etendue
