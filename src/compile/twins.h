#pragma once
/// Finds primitives that are not needed in the tree, because no ray could tell that they are there.

#include <cstdint>
#include <vector>

#include "gpu_types.h"

namespace etendue {

/// A primitive that is left out, and the one that stands for it.
struct Twin {
  std::uint32_t primitive;
  std::uint32_t stands_for_it;  ///< an earlier one with the same vertices, or itself if no ray can hit it
};

/// The primitives, in ascending order, that have exactly the vertices of an earlier one in the same order (or its
/// centre and radius), and the triangles with two equal vertices, which are never hit. A ray that meets one of
/// thousands of twins meets them all, and no tree can separate them. An instance that rays may pass (true in
/// `passing_instances`) stands for no other.
std::vector<Twin> find_twins(const std::vector<gpu::Primitive>& primitives,
                             const std::vector<bool>& passing_instances = {});

}  // namespace etendue
