#pragma once
/// The layout of a node of the wide tree in texels of 16 bytes, for either width, and functions to read it back: the
/// host's counterpart of shaders/node4.glsl and shaders/node8.glsl. Which width the kernels walk is gpu::kBvhWidth;
/// both are built and tested.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "compile/box.h"
#include "core/page_memory.h"
#include "gpu_types.h"

namespace etendue {

using Texel = gpu::uvec4;
using TexelVector = PageVector<Texel>;

inline constexpr std::uint32_t kPrimitiveTexels = gpu::kRecordTexels;

/// The grid of a node's boxes: along axis k the coordinate q stands for origin[k] + q · scale[k].
struct NodeGrid {
  glm::vec3 origin;
  glm::vec3 scale;  ///< powers of two
};
/// A child's box in its parent's grid, 0 to 255. An absent child has lower 255 and upper 0.
struct GridBox {
  glm::uvec3 lower{255u};
  glm::uvec3 upper{0u};
};
/// The location of a node's children.
struct ChildGroup {
  std::uint32_t first_texel;  ///< a multiple of the layout's kGroupTexels
  std::uint32_t count;        ///< 2 to the layout's width
  std::uint32_t inner;        ///< number of those that are nodes
};

/// A layout has
///   kNodeTexels          texels per node,
///   kSlotTexels          texels per slot: slot s begins at texel s · kSlotTexels,
///   kGroupTexels         the children of a node begin at a multiple of it,
///   kNodesFirst          whether the children that are nodes come before those that are primitives,
///   kTailTexels          texels after the last record that a kernel may load and does not use,
///   kMaxTexels           texels that a node can address,
///   kTexelsPerPrimitive  approximate number in the finished tree of a mesh,
///   fit_grid             the finest grid over a box that the layout can represent,
///   encode               a node, from its grid, its children's boxes and their place,
///   grid, box, group     what was encoded.
template <std::uint32_t width>
struct NodeLayout;

/// 48 bytes: boxes as uvec4 bytes by axis, nodes and primitives of equal size.
template <>
struct NodeLayout<4> {
  static constexpr std::uint32_t kNodeTexels = 3;
  static constexpr std::uint32_t kSlotTexels = 3;
  static constexpr std::uint32_t kGroupTexels = 6;  // an even slot: half of it fits into 24 bits of a stack entry
  static constexpr bool kNodesFirst = false;
  static constexpr std::uint32_t kTailTexels = 0;
  static constexpr std::uint64_t kMaxTexels = kSlotTexels * (std::uint64_t{1} << 25);
  static constexpr double kTexelsPerPrimitive = 4.4;

  static NodeGrid fit_grid(const Box& box);
  static void encode(const NodeGrid& grid, std::span<const GridBox, 4> boxes, const ChildGroup& group, Texel* node);
  static NodeGrid grid(const Texel* node);
  static GridBox box(const Texel* node, std::uint32_t child);
  static ChildGroup group(const Texel* node);
};

/// 64 bytes, a cache line: nodes first, then primitives [Ylitie2017], so that a child's place follows from its number.
template <>
struct NodeLayout<8> {
  static constexpr std::uint32_t kNodeTexels = 4;
  static constexpr std::uint32_t kSlotTexels = 1;
  static constexpr std::uint32_t kGroupTexels = 4;  // cache lines
  static constexpr bool kNodesFirst = true;
  static constexpr std::uint32_t kTailTexels = 1;  // a step loads four texels, even for primitives
  static constexpr std::uint64_t kMaxTexels = kGroupTexels * (std::uint64_t{gpu::kNode8BaseMask} + 1);
  static constexpr double kTexelsPerPrimitive = 4.1;

  /// Coordinates must lie in [−2, 2). Throws Error(bug) for others, which cannot occur in normalised scenes.
  static NodeGrid fit_grid(const Box& box);
  static void encode(const NodeGrid& grid, std::span<const GridBox, 8> boxes, const ChildGroup& group, Texel* node);
  static NodeGrid grid(const Texel* node);
  static GridBox box(const Texel* node, std::uint32_t child);
  static ChildGroup group(const Texel* node);
};

/// The kernels' layout.
using KernelLayout = NodeLayout<gpu::kBvhWidth>;
static_assert(KernelLayout::kSlotTexels == gpu::kSlotTexels);

/// Texels from the start of a group of children to child `child`.
template <typename Layout>
constexpr std::uint32_t child_offset(std::uint32_t child, std::uint32_t inner) {
  return kPrimitiveTexels * child + (Layout::kNodeTexels - kPrimitiveTexels) * std::min(child, inner);
}

/// The smallest box of the grid that contains `box`, which must be inside the grid.
GridBox quantize(const NodeGrid& grid, const Box& box);
/// The corners of a box, as computed by the kernels.
inline Box dequantize(const NodeGrid& grid, const GridBox& q) {
  return {grid.origin + glm::vec3(q.lower) * grid.scale, grid.origin + glm::vec3(q.upper) * grid.scale};
}

/// Reads a finished tree, slot by slot.
template <std::uint32_t width>
class TreeReader {
 public:
  using Layout = NodeLayout<width>;
  explicit TreeReader(const TexelVector& texels) : texels_(texels) {}

  bool is_node(std::uint32_t slot) const { return (at(slot)->w & gpu::kRecordNode) != 0; }
  gpu::Primitive primitive(std::uint32_t slot) const {
    gpu::Primitive p;
    std::memcpy(static_cast<void*>(&p), at(slot), sizeof p);
    return p;
  }
  NodeGrid grid(std::uint32_t slot) const { return Layout::grid(at(slot)); }
  GridBox grid_box(std::uint32_t slot, std::uint32_t child) const { return Layout::box(at(slot), child); }
  /// Conservative: contains the exact box of everything below.
  Box child_box(std::uint32_t slot, std::uint32_t child) const { return dequantize(grid(slot), grid_box(slot, child)); }
  std::uint32_t child_count(std::uint32_t slot) const { return Layout::group(at(slot)).count; }
  std::uint32_t child_slot(std::uint32_t slot, std::uint32_t child) const {
    const ChildGroup group = Layout::group(at(slot));
    const std::uint32_t inner = Layout::kNodesFirst ? group.inner : 0;
    return (group.first_texel + child_offset<Layout>(child, inner)) / Layout::kSlotTexels;
  }

 private:
  const Texel* at(std::uint32_t slot) const { return &texels_.at(std::size_t{slot} * Layout::kSlotTexels); }
  const TexelVector& texels_;
};

}  // namespace etendue
