#pragma once
/// Lamps that are much brighter in some places than in others: docs/conventions.md, "Lamps of varying brightness".

#include <cstdint>
#include <map>
#include <vector>

#include "scene/scene.h"

namespace etendue {

/// The parts into which the triangles of a lamp are divided, so that light is sampled where it comes from. A triangle
/// has `cells`² of them: the square of the two numbers (u, v) that choose its points is divided into cells of side
/// 1/cells, and cell i · cells + j begins at (i/cells, j/cells).
struct LampParts {
  std::vector<std::uint32_t> cells;  ///< of each triangle, along a side
  std::vector<std::uint32_t> first;  ///< of each triangle, its first part; one more entry: the number of all parts
  std::vector<double> brightness;    ///< of each part: luminance, positive if any of it shines

  bool empty() const { return cells.empty(); }
};

/// The parts of all lamps that have some, by instance: those of textured meshes whose brightness varies, except for
/// shared meshes. There are at most 2^18 of them in all, or one for each triangle; textures are looked up at no more
/// than about 2^22 points.
std::map<std::uint32_t, LampParts> lamp_parts(const Scene& scene);

}  // namespace etendue
