#pragma once
/// A surface on which a single material is tested.

#include "scene/scene.h"

namespace etendue {

/// Adds to a scene without shapes one flat triangle of the material in the last row of its table. The material is
/// tested at the triangle's first corner, where the texture coordinates are `uv` and grow along X and Y, by 1 per scene
/// unit; the normal is +Z, so that local directions are those of the world.
void add_test_patch(Scene& scene, const glm::dvec2& uv = {0.3, 0.6});

/// Such a scene of a material without textures.
Scene test_patch(const Bsdf& bsdf);

}  // namespace etendue
