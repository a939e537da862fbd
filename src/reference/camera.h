#pragma once
/// Cameras; docs/conventions.md, "Camera and filter".

#include "reference/ray.h"
#include "reference/rng.h"
#include "scene/scene.h"

namespace etendue::reference {

/// The ray through film position `film` (pixels; (0,0) is the top left corner of the top left pixel). Its interval runs
/// from the near to the far clipping plane. `lens` is looked at by cameras with an aperture, and by meters of
/// irradiance.
Ray camera_ray(const Camera& camera, const Vec2& film, const SampleRandom::Lens& lens = {0.5, 0.5, 0.5});

/// What a sample of radiance along that ray is multiplied by: π for a meter of irradiance, else 1.
double camera_weight(const Camera& camera);

}  // namespace etendue::reference
