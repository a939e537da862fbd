#pragma once
/// Lights without extent; docs/conventions.md, "Lights without extent".

#include "reference/vec.h"
#include "scene/scene.h"

namespace etendue::reference {

/// Intensity of a point, spot or projector along the unit direction `w` away from it.
Vec3 intensity(const Scene& scene, const DeltaLight& light, const Vec3& w);

/// Its weight in a choice by power: Φ/π; for a directional light its irradiance.
double choice_power(const Scene& scene, const DeltaLight& light);

/// Cosine of the half angle of the cone of emission around its axis.
double cone_cosine(const DeltaLight& light);

}  // namespace etendue::reference
