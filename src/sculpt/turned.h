#pragma once
/// Surfaces with texture coordinates: turned vessels, a curtain and a flat square.

#include <cstdint>

#include "sculpt/mesh.h"

namespace etendue::sculpt {

/// A vase of height 1 on y = 0, open at the top, with walls about 0.02 thick and with normals. u runs around it; v runs
/// up the outside from 0 to 1, and down the inside beyond 1.
Mesh vase(std::uint64_t triangles);
/// A bowl of radius 0.5 on y = 0, like the vase.
Mesh bowl(std::uint64_t triangles);
/// A wine glass of height 1 on y = 0; its surface is closed, and the walls are about 0.012 thick.
Mesh goblet(std::uint64_t triangles);
/// A sheet over [-0.5, 0.5] × [0, 1] with seven folds along y, about 0.08 deep. Normals point toward +z; (u, v) follow
/// x and y.
Mesh curtain(std::uint64_t triangles);
/// The square [-0.5, 0.5]² in y = 0, facing up: two triangles with (u, v) from (0, 0) at (−x, +z) to (1, 1).
Mesh tile();

}  // namespace etendue::sculpt
