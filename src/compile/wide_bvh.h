#pragma once
/// Binary BVH → quantised 4-wide BVH [Wald2008] in the record layout of shaders/gpu_types.h.

#include <cstdint>
#include <vector>

#include "compile/bvh.h"
#include "gpu_types.h"

namespace etendue {

/// Nodes and primitives that a tree can have: what a stack entry can address.
inline constexpr std::uint64_t kMaxRecords = std::uint64_t{1} << 25;

struct WideBvh {
  std::vector<gpu::Record> records;    ///< nodes and primitives share the array
  std::vector<std::uint32_t> slot_of;  ///< record index of each primitive
  std::uint32_t root = gpu::kNone;     ///< record of the root; kNone for an empty tree
  std::uint32_t depth = 0;             ///< levels of nodes: the stack never holds more entries
};

/// `primitives` are in their original order. Children of a node are neighbours, their group starts at an even record,
/// so that a group needs 24 bits in a stack entry. The same bytes for any number of threads. Throws Error(scene_error)
/// beyond 2^25 records.
/// `outside`, primitives that stand outside the tree, become the first records.
WideBvh make_wide_bvh(const Bvh& bvh, const std::vector<gpu::Primitive>& primitives,
                      const std::vector<std::uint32_t>& outside = {});

/// A primitive as it stands among the records.
gpu::Record to_record(const gpu::Primitive& primitive);

/// The boxes of a node's children as the kernel decodes them, for tests: conservative, they contain the exact boxes.
Box decode_child_box(const gpu::Record& node, std::uint32_t child);
bool is_node(const gpu::Record& record);
/// Number of children of a node and the record of the first one.
std::uint32_t child_count(const gpu::Record& node);
std::uint32_t child_base(const gpu::Record& node);

}  // namespace etendue
