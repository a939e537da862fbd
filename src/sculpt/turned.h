#pragma once
/// Surfaces with texture coordinates: what is turned on a lathe, a curtain and a flat square.

#include <cstdint>

#include "sculpt/mesh.h"

namespace etendue::sculpt {

/// A vase of height 1 on y = 0, open on top, its wall about 0.02 thick, with normals. u runs around, v up the outside
/// in [0,1] and down the inside beyond 1.
Mesh vase(std::uint64_t triangles);
/// A bowl of radius 0.5 on y = 0, like the vase.
Mesh bowl(std::uint64_t triangles);
/// A wine glass of height 1 on y = 0, closed: the wall of its cup is about 0.012 thick.
Mesh goblet(std::uint64_t triangles);
/// A sheet of seven folds along y, [-0.5, 0.5] × [0, 1], about 0.08 deep, the normals toward +z; (u, v) follows x and
/// y.
Mesh curtain(std::uint64_t triangles);
/// The square [-0.5, 0.5]² in y = 0 that faces up: two triangles, (u, v) from (0, 0) at (−x, +z) to (1, 1).
Mesh tile();

}  // namespace etendue::sculpt
