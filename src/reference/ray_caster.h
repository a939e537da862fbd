#pragma once
/// The reference's hierarchy as a caster of single rays.

#include "render/ray_caster.h"

namespace etendue {

/// `placement` says where the coordinates of the rays lie; the reference itself works in world space.
std::unique_ptr<RayCaster> make_reference_ray_caster(const Scene& scene, const Placement& placement);

}  // namespace etendue
