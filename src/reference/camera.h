#pragma once
/// Perspective camera; docs/conventions.md, "Camera and filter".

#include "reference/ray.h"
#include "scene/scene.h"

namespace etendue::reference {

/// The ray through film position `film` (pixels; (0,0) is the top left corner of the top left pixel). Its interval runs
/// from the near to the far clipping plane.
Ray camera_ray(const Camera& camera, const Vec2& film);

}  // namespace etendue::reference
