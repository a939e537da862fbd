#pragma once
/// Transforms that keep circles round: rotations, reflections, translations and one scale.

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// Axes of equal length at right angles, but for rounding: what keeps a sphere a sphere.
bool is_similarity(const glm::dmat4& m);

/// Files often give matrices with few digits. Where the scene needs a similarity (sky, lights, spheres, cylinders), a
/// transform whose axes are alike and at right angles to half a thousandth becomes the nearest one; any other stays as
/// it is.
void round_to_similarities(Scene& scene);

}  // namespace etendue
