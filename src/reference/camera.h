#pragma once
/// Cameras; docs/conventions.md, "Camera and filter".

#include "reference/ray.h"
#include "reference/rng.h"
#include "scene/scene.h"

namespace etendue::reference {

/// The ray through film position `film` (pixels; (0,0) is the top left corner of the top left pixel). Its interval runs
/// from the near to the far clipping plane. `lens` is used by cameras with an aperture and by irradiance meters.
Ray camera_ray(const Camera& camera, const Vec2& film, const SampleRandom::Lens& lens = {0.5, 0.5, 0.5});

/// The factor of a radiance sample along that ray: π for an irradiance meter, otherwise 1.
double camera_weight(const Camera& camera);

}  // namespace etendue::reference
