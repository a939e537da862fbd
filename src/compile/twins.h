#pragma once
/// Primitives that need no place in the tree, because no ray can tell that they are there.

#include <cstdint>
#include <vector>

#include "gpu_types.h"

namespace etendue {

/// A primitive that is left out, and the one that stands for it.
struct Twin {
  std::uint32_t primitive;
  std::uint32_t stands_for_it;  ///< an earlier one with the same vertices, or itself where no ray hits either
};

/// The primitives, ascending, that have exactly the vertices of an earlier one in the same order (or centre and
/// radius), and the triangles with two equal vertices, which are never hit. A ray that meets one of thousands of twins
/// meets them all, and no tree can part them. An instance that a ray may pass, `passing_instances` true, stands for no
/// other.
std::vector<Twin> find_twins(const std::vector<gpu::Primitive>& primitives,
                             const std::vector<bool>& passing_instances = {});

}  // namespace etendue
