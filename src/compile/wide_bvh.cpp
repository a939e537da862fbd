#include "compile/wide_bvh.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/parallel.h"

namespace etendue {
namespace {

constexpr std::uint32_t kWidth = 4;
// Levels beyond the least possible ones: one lets the cheapest collapse be taken nearly everywhere.
constexpr std::uint32_t kSpareLevels = 0;
constexpr std::uint64_t kGrain = 1u << 14;

// Nodes of the binary tree that become the children of a wide node.
struct Children {
  std::uint32_t node[kWidth];
  std::uint32_t count = 0;
};

// Which nodes of a binary tree become wide ones [Ylitie2017]. A wide node takes the place of a small tree of binary
// nodes; its children are what hangs below, at most four. For every binary node and k = 1, 2, 3 the plan holds the
// lowest cost of its subtree when k children of a wide node are spent on it. A step of the walk is a fetch of one
// record, node or primitive alike, so the cost of a record is the chance that a ray meets its box: its area.
//
// Cost alone makes some paths longer than need be, and the kernel's stack has an entry for each level of the deepest
// one. So the plan also holds the least number of levels, and where the cheap way would need more than the root's
// allowance, the flat way is taken.
class CollapsePlan {
 public:
  explicit CollapsePlan(const Bvh& bvh) : nodes_(bvh.nodes), entries_((nodes_.size() - 1) / 2) {
    std::vector<std::uint32_t> order = inner_nodes_top_down();
    for (auto it = order.rbegin(); it != order.rend(); ++it) fill(*it);
  }

  /// Least levels of wide nodes below and including `node`.
  std::uint32_t least_levels(std::uint32_t node) const { return levels(node, 1); }

  /// The children of the wide node at `node` if what is below may have `allowed` levels.
  Children children(std::uint32_t node, std::uint32_t allowed) const {
    const Children cheap = children(node, &Entry::left_share);
    for (std::uint32_t i = 0; i < cheap.count; ++i) {
      if (least_levels(cheap.node[i]) > allowed) return children(node, &Entry::flat_share);
    }
    return cheap;
  }

 private:
  using Shares = std::array<std::uint8_t, kWidth - 1>;
  struct Entry {
    std::array<float, kWidth - 1> cost;           // with k = 1, 2, 3 children of a wide node
    std::array<std::uint8_t, kWidth - 1> levels;  // least levels with k children
    Shares left_share;  // of k = 2, 3, 4 children, how many go to the left subtree at the lowest cost; 0: k − 1
                        // children are as good
    Shares flat_share;  // the same for the least levels
  };

  // Inner nodes are numbered by their pair of children.
  const Entry& entry(std::uint32_t node) const { return entries_[(nodes_[node].first - 1) / 2]; }
  float area(std::uint32_t node) const { return nodes_[node].box.half_area(); }
  float cost(std::uint32_t node, std::uint32_t k) const {
    return nodes_[node].leaf != 0 ? area(node) : entry(node).cost[k - 1];
  }
  std::uint32_t levels(std::uint32_t node, std::uint32_t k) const {
    return nodes_[node].leaf != 0 ? 0 : entry(node).levels[k - 1];
  }

  std::vector<std::uint32_t> inner_nodes_top_down() const {
    std::vector<std::uint32_t> order;
    order.reserve(entries_.size());
    if (nodes_[0].leaf == 0) order.push_back(0);
    for (std::size_t i = 0; i < order.size(); ++i) {
      for (const std::uint32_t child : {nodes_[order[i]].first, nodes_[order[i]].first + 1}) {
        if (nodes_[child].leaf == 0) order.push_back(child);
      }
    }
    return order;
  }

  void fill(std::uint32_t node) {
    const std::uint32_t left = nodes_[node].first, right = left + 1;
    Entry e{};
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
    e.cost[0] = area(node) + split_cost[kWidth];
    e.levels[0] = static_cast<std::uint8_t>(1 + split_levels[kWidth]);
    for (std::uint32_t k = 2; k < kWidth; ++k) {
      const bool cheaper = split_cost[k] <= e.cost[k - 2], flatter = split_levels[k] <= e.levels[k - 2];
      e.cost[k - 1] = cheaper ? split_cost[k] : e.cost[k - 2];
      e.levels[k - 1] = flatter ? static_cast<std::uint8_t>(split_levels[k]) : e.levels[k - 2];
      if (!cheaper) e.left_share[k - 2] = 0;
      if (!flatter) e.flat_share[k - 2] = 0;
    }
    entries_[(left - 1) / 2] = e;
  }

  // The binary nodes that the subtree contributes when k children of a wide node are spent on it.
  void collect(std::uint32_t node, std::uint32_t k, Shares Entry::*shares, Children& out) const {
    if (k == 1 || nodes_[node].leaf != 0) {
      out.node[out.count++] = node;
      return;
    }
    const std::uint32_t left = (entry(node).*shares)[k - 2];
    if (left == 0) return collect(node, k - 1, shares, out);
    collect(nodes_[node].first, left, shares, out);
    collect(nodes_[node].first + 1, k - left, shares, out);
  }
  Children children(std::uint32_t node, Shares Entry::*shares) const {
    Children out;
    const std::uint32_t left = (entry(node).*shares)[kWidth - 2];
    collect(nodes_[node].first, left, shares, out);
    collect(nodes_[node].first + 1, kWidth - left, shares, out);
    return out;
  }

  const std::vector<BvhNode>& nodes_;
  std::vector<Entry> entries_;
};

// Smallest exponent with 255 · 2^e >= extent, biased by 127 and kept in the range of normal floats.
std::uint32_t biased_exponent(float extent) {
  int e = 0;
  std::frexp(extent / 255.0f, &e);
  if (extent == 0.0f) e = -126;
  return static_cast<std::uint32_t>(std::max(e, -126) + 127);
}

float exponent_scale(std::uint32_t biased) {
  return std::bit_cast<float>(biased << 23);
}

// Grid coordinates whose decoded planes enclose [lower, upper].
void quantize(float lower, float upper, float origin, float scale, std::uint32_t& q_lower, std::uint32_t& q_upper) {
  q_lower = static_cast<std::uint32_t>(std::clamp(std::floor((lower - origin) / scale), 0.0f, 255.0f));
  q_upper = static_cast<std::uint32_t>(std::clamp(std::ceil((upper - origin) / scale), 0.0f, 255.0f));
  while (q_lower > 0 && origin + static_cast<float>(q_lower) * scale > lower) --q_lower;
  while (q_upper < 255 && origin + static_cast<float>(q_upper) * scale < upper) ++q_upper;
}

// While the tree is laid out, a record holds what becomes of it: a binary node and, of an inner one, the children of
// the wide node with the record of the first.
struct Draft {
  std::uint32_t node;
  std::uint32_t leaf;  // 0 also for records that are left free
  std::uint32_t base;
  Children children;
};
static_assert(sizeof(Draft) <= sizeof(gpu::Record));
Draft read_draft(const gpu::Record& record) {
  Draft draft;
  std::memcpy(static_cast<void*>(&draft), &record, sizeof draft);
  return draft;
}
void write_draft(const Draft& draft, gpu::Record& record) {
  std::memcpy(&record, &draft, sizeof draft);
}

gpu::Record encode_node(const Bvh& bvh, const Draft& draft) {
  const Box& box = bvh.nodes[draft.node].box;
  gpu::Record r{};
  std::uint32_t exponents = 0;
  for (int a = 0; a < 3; ++a) {
    std::uint32_t e = biased_exponent(box.upper[a] - box.lower[a]);
    // The far plane must be reachable after rounding too.
    while (box.lower[a] + 255.0f * exponent_scale(e) < box.upper[a]) ++e;
    exponents |= e << (8 * a);
    r.a[a] = std::bit_cast<std::uint32_t>(box.lower[a]);
    for (std::uint32_t i = 0; i < kWidth; ++i) {
      std::uint32_t lo = 255, hi = 0;  // an empty box: never hit
      if (i < draft.children.count) {
        const Box& child = bvh.nodes[draft.children.node[i]].box;
        quantize(child.lower[a], child.upper[a], box.lower[a], exponent_scale(e), lo, hi);
      }
      r.b[a] |= lo << (8 * i);
      r.c[a] |= hi << (8 * i);
    }
  }
  r.a.w = exponents | gpu::kRecordNode | (draft.children.count << gpu::kRecordChildCountShift);
  r.b.w = draft.base;
  return r;
}

// Places all nodes, depth first, as drafts from record `root` on; returns the levels of wide nodes.
std::uint32_t lay_out(const Bvh& bvh, std::uint32_t root, std::vector<gpu::Record>& records) {
  const CollapsePlan plan(bvh);
  struct Task {
    std::uint32_t node, record, depth;
  };
  const std::uint32_t allowed = plan.least_levels(0) + kSpareLevels;
  std::uint32_t depth = 0;
  records.resize(root + 1);
  std::vector<Task> pending{{0, root, 1}};
  while (!pending.empty()) {
    const Task task = pending.back();
    pending.pop_back();
    if (bvh.nodes[task.node].leaf != 0) {
      write_draft({task.node, 1, 0, {}}, records[task.record]);
      continue;
    }
    depth = std::max(depth, task.depth);
    const Children children = plan.children(task.node, allowed - task.depth);
    const std::size_t base = (records.size() + 1) / 2 * 2;
    if (base + kWidth > kMaxRecords) {
      throw Error(ExitCode::scene_error, fmt::format("The scene has {} primitives; their tree needs more than the {} "
                                                     "records that can be addressed, which suffice "
                                                     "for about {} million. Use coarser meshes.",
                                                     (bvh.nodes.size() + 1) / 2, kMaxRecords, 23));
    }
    records.resize(base + children.count);
    write_draft({task.node, 0, static_cast<std::uint32_t>(base), children}, records[task.record]);
    for (std::uint32_t i = children.count; i-- > 0;) {
      pending.push_back({children.node[i], static_cast<std::uint32_t>(base + i), task.depth + 1});
    }
  }
  return depth;
}

}  // namespace

gpu::Record to_record(const gpu::Primitive& p) {
  gpu::Record r;
  static_assert(sizeof r == sizeof p);
  std::memcpy(&r, &p, sizeof r);
  return r;
}

WideBvh make_wide_bvh(const Bvh& bvh, const std::vector<gpu::Primitive>& primitives,
                      const std::vector<std::uint32_t>& outside) {
  WideBvh wide;
  wide.slot_of.resize(primitives.size());
  const auto first = static_cast<std::uint32_t>(outside.size());
  // Meshes take 1.4 to 1.5 records a primitive; growing by doubling would need the memory twice.
  wide.records.reserve(first + bvh.nodes.size() * 77 / 100);
  wide.records.resize(first);
  if (!bvh.nodes.empty()) {
    wide.root = first;
    wide.depth = lay_out(bvh, first, wide.records);
  }
  const auto place = [&](std::uint32_t primitive, std::uint64_t record) {
    wide.slot_of[primitive] = static_cast<std::uint32_t>(record);
    wide.records[record] = to_record(primitives[primitive]);
  };
  for (std::size_t i = 0; i < outside.size(); ++i) place(outside[i], i);
  parallel_for(wide.records.size() - first, kGrain, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = first + begin; i < first + end; ++i) {
      const Draft draft = read_draft(wide.records[i]);
      const BvhNode& node = bvh.nodes[draft.node];
      if (draft.children.count > 0) {
        wide.records[i] = encode_node(bvh, draft);
      } else if (draft.leaf != 0) {
        place(node.first, i);
      }
    }
  });
  return wide;
}

bool is_node(const gpu::Record& record) {
  return (record.a.w & gpu::kRecordNode) != 0;
}
std::uint32_t child_count(const gpu::Record& node) {
  return node.a.w >> gpu::kRecordChildCountShift & 7u;
}
std::uint32_t child_base(const gpu::Record& node) {
  return node.b.w;
}

Box decode_child_box(const gpu::Record& node, std::uint32_t child) {
  Box box;
  for (int a = 0; a < 3; ++a) {
    const auto origin = std::bit_cast<float>(node.a[a]);
    const float scale = exponent_scale(node.a.w >> (8 * a) & 0xffu);
    box.lower[a] = origin + static_cast<float>(node.b[a] >> (8 * child) & 0xffu) * scale;
    box.upper[a] = origin + static_cast<float>(node.c[a] >> (8 * child) & 0xffu) * scale;
  }
  return box;
}

}  // namespace etendue
