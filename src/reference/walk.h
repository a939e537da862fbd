#pragma once
/// Rays that go on where they have met something.

#include <optional>

#include "reference/integrator.h"
#include "reference/world.h"

namespace etendue::reference {

/// The same ray, from the surface on.
void go_behind(const Surface& surface, Ray& ray);

/// The first surface along a camera ray that is not hidden from it; `ray` then is the part that reaches it. `gathered`
/// is what the path has gathered so far, for the log.
std::optional<Surface> first_visible(const World& world, Ray& ray, const Vec3& gathered, DecisionLog& log);

}  // namespace etendue::reference
