#pragma once
/// Light from outside as tables: docs/conventions.md, "Environment".

#include <cstdint>
#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// What kernels are built for and views need to know.
struct EnvironmentFacts {
  std::uint32_t kind = gpu::kEnvironmentNone;
  std::uint32_t columns = 1, texel_rows = 1, cell_rows = 1;
  std::uint32_t row_count = 0;          ///< rows of cells without those at the end that have no weight
  std::uint32_t threshold = 0;          ///< words below it choose the environment; meaningless where it is alone
  bool alone = false;                   ///< nothing else emits
  std::uint32_t distant_threshold = 0;  ///< words from the other threshold up to this one choose a directional light
  double lights_prob = 0.0;             ///< of the choice of a light
  glm::dvec3 top{0.0}, horizon{0.0};
  glm::dmat3 world_from_sky{1.0};  ///< axes of unit length
};

struct EnvironmentTables {
  EnvironmentFacts facts;
  std::vector<std::uint64_t> distant_thresholds;  ///< of the directional lights, in their order, and one behind
  std::vector<gpu::EnvironmentRow> rows;
  std::vector<gpu::EnvironmentTexel>
      texels;                      ///< of a picture, row by row: as many rows as the larger of its two numbers
  std::vector<gpu::uvec4> search;  ///< of the rows, then of a picture's columns for each of them: see SearchTree
};

/// Without rows for a black sky. `lights_power` is the sum of luminance · area of everything that emits and stands
/// somewhere.
EnvironmentTables compile_environment(const Scene& scene, double lights_power);

}  // namespace etendue
