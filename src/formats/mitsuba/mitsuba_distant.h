#pragma once
/// Mitsuba's sensor `distant` measures the mean radiance in one direction, at a point, a rectangle, a disk or the whole
/// scene.

#include "formats/mitsuba/mitsuba_object.h"
#include "scene/bounds.h"
#include "scene/scene.h"

namespace etendue {

/// Sets everything in `camera` except its film. `bounds`: box of the scene's shapes.
void set_distant_camera(const MitsubaObject& sensor, const Bounds& bounds, const MitsubaContext& context,
                        Camera& camera);

}  // namespace etendue
