#pragma once
/// Binary BVH → quantised wide BVH [Wald2008] with four or eight children per node, in the layouts of node_layout.h.

#include <cstdint>
#include <vector>

#include "compile/bvh.h"
#include "compile/node_layout.h"
#include "gpu_types.h"

namespace etendue {

/// The number of primitives beyond which a scene cannot be addressed, whatever its tree.
inline constexpr std::uint64_t kMaxPrimitives = KernelLayout::kMaxTexels / kPrimitiveTexels;

struct WideBvh {
  TexelVector texels;                  ///< nodes and primitives share the array
  std::vector<std::uint32_t> slot_of;  ///< slot of each primitive
  std::uint32_t root = gpu::kNone;     ///< slot of the root; kNone for an empty tree
  std::uint32_t depth = 0;             ///< levels of nodes: the stack never holds more entries
};

/// `primitives` are in their original order. The children of a node are neighbours. The result is the same, byte for
/// byte, for any number of threads. Throws Error(scene) if there are more texels than the layout can address.
/// `outside` are the primitives outside the tree, which come first, one after the other. `before` are texels of other
/// trees, which stay where they are; everything else follows them.
template <std::uint32_t width>
WideBvh make_wide_bvh(const Bvh& bvh, const std::vector<gpu::Primitive>& primitives,
                      const std::vector<std::uint32_t>& outside = {}, TexelVector before = {});
extern template WideBvh make_wide_bvh<4>(const Bvh&, const std::vector<gpu::Primitive>&,
                                         const std::vector<std::uint32_t>&, TexelVector);
extern template WideBvh make_wide_bvh<8>(const Bvh&, const std::vector<gpu::Primitive>&,
                                         const std::vector<std::uint32_t>&, TexelVector);

}  // namespace etendue
