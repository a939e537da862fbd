#include "compile/wide_bvh.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/memory.h"
#include "core/parallel.h"

namespace etendue {
namespace {

// Levels allowed beyond the minimum: one would permit the cheapest collapse nearly everywhere.
constexpr std::uint32_t kSpareLevels = 0;
constexpr std::uint64_t kGrain = 1u << 14;
constexpr std::size_t kSubtrees = 1u << 10;  // of the binary tree, at least, where there are so many

// Nodes of the binary tree that become the children of a wide node.
template <std::uint32_t kWidth>
struct Children {
  std::uint32_t node[kWidth];
  std::uint32_t count = 0;
};

// Chooses which nodes of a binary tree become wide ones [Ylitie2017]. A wide node replaces a small tree of binary
// nodes; its children, at most kWidth, are the nodes below that tree. For every binary node and k = 1 … kWidth − 1 the
// plan holds the lowest cost of its subtree if k children of a wide node are spent on it. A step of the walk fetches
// one record, a node or a primitive, so the cost of a record is the probability that a ray meets its box, which is
// proportional to its area.
//
// Minimising the cost alone makes some paths longer than necessary, and the kernel's stack has an entry for each level
// of the deepest one. The plan therefore also holds the least number of levels; where the cheapest solution would
// exceed the root's allowance, the flattest is taken.
template <std::uint32_t kWidth>
class CollapsePlan {
 public:
  explicit CollapsePlan(const Bvh& bvh)
      : nodes_(bvh.nodes), entries_((nodes_.size() - 1) / 2), costs_(entries_.size()) {
    // Subtrees side by side, each in the order of memory; then what is above them.
    std::vector<std::uint32_t> above, roots{0};
    while (!roots.empty() && roots.size() < kSubtrees) {
      std::vector<std::uint32_t> below;
      for (const std::uint32_t root : roots) push_inner_children(root, below);
      above.insert(above.end(), roots.begin(), roots.end());
      roots = std::move(below);
    }
    parallel_for(roots.size(), 1, [&](std::uint64_t begin, std::uint64_t) { fill_subtree(roots[begin]); });
    for (auto it = above.rbegin(); it != above.rend(); ++it) fill(*it);
    release(costs_);
  }

  /// Least levels of wide nodes below and including `node`.
  std::uint32_t least_levels(std::uint32_t node) const { return levels(node, 1); }

  /// The children of the wide node at `node` if everything below may have `allowed` levels.
  Children<kWidth> children(std::uint32_t node, std::uint32_t allowed) const {
    const Children<kWidth> cheap = children(node, &Entry::left_share);
    for (std::uint32_t i = 0; i < cheap.count; ++i) {
      if (least_levels(cheap.node[i]) > allowed) return children(node, &Entry::flat_share);
    }
    return cheap;
  }

 private:
  using Shares = std::array<std::uint8_t, kWidth - 1>;
  struct Entry {
    std::array<std::uint8_t, kWidth - 1> levels;  // least levels with k = 1 … kWidth − 1 children of a wide node
    Shares left_share;  // for k = 2 … kWidth children, how many go to the left subtree at the lowest cost; 0: k − 1
                        // children are as good
    Shares flat_share;  // the same for the least levels
  };

  using Costs = std::array<float, kWidth - 1>;  // with k = 1 … kWidth − 1 children of a wide node

  // Inner nodes are numbered by their pair of children.
  std::size_t index(std::uint32_t node) const { return (nodes_[node].first - 1) / 2; }
  const Entry& entry(std::uint32_t node) const { return entries_[index(node)]; }
  float area(std::uint32_t node) const { return nodes_[node].box.half_area(); }
  float cost(std::uint32_t node, std::uint32_t k) const {
    return nodes_[node].leaf != 0 ? area(node) : costs_[index(node)][k - 1];
  }
  std::uint32_t levels(std::uint32_t node, std::uint32_t k) const {
    return nodes_[node].leaf != 0 ? 0 : entry(node).levels[k - 1];
  }

  void push_inner_children(std::uint32_t node, std::vector<std::uint32_t>& out) const {
    for (const std::uint32_t child : {nodes_[node].first, nodes_[node].first + 1}) {
      if (nodes_[child].leaf == 0) out.push_back(child);
    }
  }

  void fill_subtree(std::uint32_t root) {
    std::vector<std::uint32_t> pending{root}, order;  // parents first
    while (!pending.empty()) {
      order.push_back(pending.back());
      pending.pop_back();
      push_inner_children(order.back(), pending);
    }
    for (auto it = order.rbegin(); it != order.rend(); ++it) fill(*it);
  }

  void fill(std::uint32_t node) {
    const std::uint32_t left = nodes_[node].first, right = left + 1;
    Entry e{};
    Costs cost_of;
    constexpr std::size_t kCounts = kWidth + 1;  // by number of children; 0 and 1 are not used
    std::array<float, kCounts> split_cost;
    std::array<std::uint32_t, kCounts> split_levels;
    for (std::uint32_t k = 2; k <= kWidth; ++k) {
      split_cost[k] = std::numeric_limits<float>::infinity();
      split_levels[k] = ~0u;
      for (std::uint32_t share = 1; share < k; ++share) {
        const float c = cost(left, share) + cost(right, k - share);
        const std::uint32_t l = std::max(levels(left, share), levels(right, k - share));
        if (c < split_cost[k]) split_cost[k] = c, e.left_share[k - 2] = static_cast<std::uint8_t>(share);
        if (l < split_levels[k]) split_levels[k] = l, e.flat_share[k - 2] = static_cast<std::uint8_t>(share);
      }
    }
    cost_of[0] = area(node) + split_cost[kWidth];
    e.levels[0] = static_cast<std::uint8_t>(1 + split_levels[kWidth]);
    for (std::uint32_t k = 2; k < kWidth; ++k) {
      const bool cheaper = split_cost[k] <= cost_of[k - 2], flatter = split_levels[k] <= e.levels[k - 2];
      cost_of[k - 1] = cheaper ? split_cost[k] : cost_of[k - 2];
      e.levels[k - 1] = flatter ? static_cast<std::uint8_t>(split_levels[k]) : e.levels[k - 2];
      if (!cheaper) e.left_share[k - 2] = 0;
      if (!flatter) e.flat_share[k - 2] = 0;
    }
    entries_[index(node)] = e;
    costs_[index(node)] = cost_of;
  }

  // The binary nodes that the subtree contributes if k children of a wide node are spent on it.
  void collect(std::uint32_t node, std::uint32_t k, Shares Entry::*shares, Children<kWidth>& out) const {
    if (k == 1 || nodes_[node].leaf != 0) {
      out.node[out.count++] = node;
      return;
    }
    const std::uint32_t left = (entry(node).*shares)[k - 2];
    if (left == 0) return collect(node, k - 1, shares, out);
    collect(nodes_[node].first, left, shares, out);
    collect(nodes_[node].first + 1, k - left, shares, out);
  }
  Children<kWidth> children(std::uint32_t node, Shares Entry::*shares) const {
    Children<kWidth> out;
    const std::uint32_t left = (entry(node).*shares)[kWidth - 2];
    collect(nodes_[node].first, left, shares, out);
    collect(nodes_[node].first + 1, kWidth - left, shares, out);
    return out;
  }

  const std::vector<BvhNode>& nodes_;
  std::vector<Entry> entries_;
  std::vector<Costs> costs_;  // while the plan is made
};

// While the tree is being laid out, the texels of a node hold this draft.
template <std::uint32_t kWidth>
struct Draft {
  std::uint32_t node;  // of the binary tree
  ChildGroup group;
  Children<kWidth> children;
};

// Writes a wide tree into texels: first drafts of all nodes, depth first, then their final bytes and the primitives.
template <std::uint32_t kWidth>
class WideBuilder {
 public:
  using Layout = NodeLayout<kWidth>;
  static_assert(sizeof(Draft<kWidth>) <= Layout::kNodeTexels * sizeof(Texel));

  WideBuilder(const Bvh& bvh, const std::vector<gpu::Primitive>& primitives) : bvh_(bvh), primitives_(primitives) {}

  WideBvh build(const std::vector<std::uint32_t>& outside, TexelVector before) {
    wide_.texels = std::move(before);
    const std::size_t first = round_up(wide_.texels.size(), Layout::kNodeTexels);
    const std::size_t root = round_up(first + kPrimitiveTexels * outside.size(), Layout::kNodeTexels);
    wide_.slot_of.resize(primitives_.size());
    // Growing by doubling would need twice the memory.
    wide_.texels.reserve(
        root + static_cast<std::size_t>(1.05 * Layout::kTexelsPerPrimitive * static_cast<double>(leaf_count())));
    wide_.texels.resize(root);
    for (std::size_t i = 0; i < outside.size(); ++i) place(outside[i], first + kPrimitiveTexels * i);
    if (!bvh_.nodes.empty()) {
      wide_.root = slot(root);
      lay_out(root);
      parallel_for(nodes_.size(), kGrain, [&](std::uint64_t begin, std::uint64_t end) {
        for (std::uint64_t i = begin; i < end; ++i) finish(nodes_[i]);
      });
    }
    wide_.texels.resize(wide_.texels.size() + Layout::kTailTexels);
    return std::move(wide_);
  }

 private:
  static std::size_t round_up(std::size_t n, std::size_t step) { return (n + step - 1) / step * step; }
  static std::uint32_t slot(std::size_t texel) { return static_cast<std::uint32_t>(texel / Layout::kSlotTexels); }
  std::size_t leaf_count() const { return (bvh_.nodes.size() + 1) / 2; }
  bool is_leaf(std::uint32_t node) const { return bvh_.nodes[node].leaf != 0; }

  void place(std::uint32_t primitive, std::size_t texel) {
    wide_.slot_of[primitive] = slot(texel);
    std::memcpy(&wide_.texels[texel], &primitives_[primitive], sizeof(gpu::Primitive));
  }

  // Appends space for a node's children.
  ChildGroup make_group(Children<kWidth>& children) {
    const auto nodes_end = [&] {
      const auto is_inner = [&](std::uint32_t node) { return !is_leaf(node); };
      std::uint32_t* const end = children.node + children.count;
      if (Layout::kNodesFirst) return std::stable_partition(children.node, end, is_inner);
      return children.node;
    }();
    const auto inner = static_cast<std::uint32_t>(nodes_end - children.node);
    const std::size_t first = round_up(wide_.texels.size(), Layout::kGroupTexels);
    const std::size_t end = first + child_offset<Layout>(children.count, inner);
    if (end + Layout::kTailTexels > Layout::kMaxTexels) {
      throw Error(ErrorKind::scene,
                  fmt::format("The scene has {} primitives; their tree needs more than the {} texels that can be "
                              "addressed, which is enough for about {:.0f} million. Use coarser meshes.",
                              leaf_count(), Layout::kMaxTexels,
                              static_cast<double>(Layout::kMaxTexels) / Layout::kTexelsPerPrimitive * 1e-6));
    }
    wide_.texels.resize(end);
    return {static_cast<std::uint32_t>(first), children.count, inner};
  }

  // Places all nodes as drafts, the root at texel `root`.
  void lay_out(std::size_t root) {
    if (is_leaf(0)) {
      wide_.texels.resize(root + kPrimitiveTexels);
      place(bvh_.nodes[0].first, root);
      return;
    }
    const CollapsePlan<kWidth> plan(bvh_);
    const std::uint32_t allowed = plan.least_levels(0) + kSpareLevels;
    struct Task {
      std::uint32_t node, texel, depth;
    };
    wide_.texels.resize(root + Layout::kNodeTexels);
    std::vector<Task> pending{{0, static_cast<std::uint32_t>(root), 1}};
    while (!pending.empty()) {
      const Task task = pending.back();
      pending.pop_back();
      wide_.depth = std::max(wide_.depth, task.depth);
      nodes_.push_back(task.texel);
      Draft<kWidth> draft{task.node, {}, plan.children(task.node, allowed - task.depth)};
      draft.group = make_group(draft.children);
      std::memcpy(&wide_.texels[task.texel], &draft, sizeof draft);
      for (std::uint32_t i = draft.children.count; i-- > 0;) {
        if (is_leaf(draft.children.node[i])) continue;
        pending.push_back({draft.children.node[i], draft.group.first_texel + child_offset<Layout>(i, draft.group.inner),
                           task.depth + 1});
      }
    }
  }

  // Turns the draft at `texel` into the node, and places its children that are primitives.
  void finish(std::uint32_t texel) {
    Draft<kWidth> draft;
    std::memcpy(static_cast<void*>(&draft), &wide_.texels[texel], sizeof draft);
    const NodeGrid grid = Layout::fit_grid(bvh_.nodes[draft.node].box);
    std::array<GridBox, kWidth> boxes;
    for (std::uint32_t i = 0; i < draft.children.count; ++i) {
      const BvhNode& child = bvh_.nodes[draft.children.node[i]];
      boxes[i] = quantize(grid, child.box);
      if (child.leaf != 0) place(child.first, draft.group.first_texel + child_offset<Layout>(i, draft.group.inner));
    }
    Layout::encode(grid, boxes, draft.group, &wide_.texels[texel]);
  }

  const Bvh& bvh_;
  const std::vector<gpu::Primitive>& primitives_;
  WideBvh wide_;
  std::vector<std::uint32_t> nodes_;  // texels of all nodes, depth first
};

}  // namespace

template <std::uint32_t width>
WideBvh make_wide_bvh(const Bvh& bvh, const std::vector<gpu::Primitive>& primitives,
                      const std::vector<std::uint32_t>& outside, TexelVector before) {
  return WideBuilder<width>(bvh, primitives).build(outside, std::move(before));
}
template WideBvh make_wide_bvh<4>(const Bvh&, const std::vector<gpu::Primitive>&, const std::vector<std::uint32_t>&,
                                  TexelVector);
template WideBvh make_wide_bvh<8>(const Bvh&, const std::vector<gpu::Primitive>&, const std::vector<std::uint32_t>&,
                                  TexelVector);

}  // namespace etendue
