#pragma once
/// Lights without extent as tables: docs/conventions.md, "Lights without extent".

#include <vector>

#include "compile/light_tree.h"
#include "compile/normalization.h"
#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// The record of a light. Its probabilities and thresholds are set by the caller, who knows all lights.
gpu::DeltaLight flatten_delta_light(const Scene& scene, std::uint32_t number, const Normalization& normalization);

/// The weight of a light in the choice by power: Φ/π, comparable with luminance times area. For a directional light it
/// is the luminance of its irradiance, as for a disk of area π around the scene.
double delta_light_power(const Scene& scene, const DeltaLight& light);

/// A leaf of the light tree; not for directional lights.
LightLeaf delta_light_leaf(const Scene& scene, const DeltaLight& light);

/// Indices of the lights of a scene in the order of the table, without black ones.
std::vector<std::uint32_t> delta_light_order(const Scene& scene);

}  // namespace etendue
