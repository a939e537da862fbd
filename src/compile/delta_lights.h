#pragma once
/// Lights without extent as tables: docs/conventions.md, "Lights without extent".

#include <vector>

#include "compile/light_tree.h"
#include "compile/normalization.h"
#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// A light as a device needs it; its probabilities and thresholds are up to who knows all lights.
gpu::DeltaLight flatten_delta_light(const Scene& scene, std::uint32_t number, const Normalization& normalization);

/// What a light counts for where lights are chosen by power: Φ/π, comparable with luminance times area. Of a
/// directional light it is the luminance of its irradiance, for a disk of area π around the scene.
double delta_light_power(const Scene& scene, const DeltaLight& light);

/// A leaf of the light tree; not of a directional light.
LightLeaf delta_light_leaf(const Scene& scene, const DeltaLight& light);

/// Numbers of the lights of a scene in the order of the table, without those that are black.
std::vector<std::uint32_t> delta_light_order(const Scene& scene);

}  // namespace etendue
