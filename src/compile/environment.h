#pragma once
/// Light from outside as tables: docs/conventions.md, "Environment".

#include <cstdint>
#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// The facts that kernels are specialised for and that views depend on.
struct EnvironmentFacts {
  std::uint32_t kind = gpu::kEnvironmentNone;
  std::uint32_t columns = 1, texel_rows = 1, cell_rows = 1;
  std::uint32_t row_count = 0;          ///< rows of cells, not counting the last ones without weight
  std::uint32_t threshold = 0;          ///< words below it choose the environment; meaningless if `alone`
  bool alone = false;                   ///< nothing else emits
  std::uint32_t distant_threshold = 0;  ///< words from `threshold` up to this one choose a directional light
  double lights_prob = 0.0;             ///< probability of choosing a light
  glm::dvec3 top{0.0}, horizon{0.0};
  glm::dmat3 world_from_sky{1.0};  ///< axes of unit length
};

struct EnvironmentTables {
  EnvironmentFacts facts;
  std::vector<std::uint64_t> distant_thresholds;  ///< of the directional lights, in their order, and one past the last
  std::vector<gpu::EnvironmentRow> rows;
  std::vector<gpu::EnvironmentTexel>
      texels;                      ///< of a picture, row by row: as many rows as the larger of its two numbers
  std::vector<gpu::uvec4> search;  ///< of the rows, then of the picture's columns for each row: see SearchTree
};

/// A black sky has no rows. `lights_power` is the sum of luminance · area over everything that emits and has a
/// position.
EnvironmentTables compile_environment(const Scene& scene, double lights_power);

}  // namespace etendue
