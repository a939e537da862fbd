#include "compile/bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <span>

#include "core/long_task.h"
#include "core/memory.h"
#include "core/parallel.h"

namespace etendue {
namespace {

constexpr std::uint32_t kMaxBins = 64;
constexpr std::uint32_t kLeastTogether = 1u << 16;  // items of a node that all threads split together

// Four lanes of a register, the last of which is unused: a box grows by one instruction per side.
using Lanes = float __attribute__((vector_size(16)));
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kMax = std::numeric_limits<float>::max();

struct LaneBox {
  Lanes lower{kInf, kInf, kInf, kInf};
  Lanes upper{-kInf, -kInf, -kInf, -kInf};

  void extend(Lanes from, Lanes to) {
    lower = from < lower ? from : lower;
    upper = to > upper ? to : upper;
  }
  void extend(const LaneBox& other) { extend(other.lower, other.upper); }
  Lanes center() const { return 0.5f * (lower + upper); }
  Lanes extent() const { return upper - lower; }
  float half_area() const {
    const Lanes d = extent();
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
};

// A primitive while the tree is built. Items are moved, not their indices, so that every pass reads memory in order.
// The number of the primitive is stored in the unused lane, with an exponent that makes it a normal float, because
// denormal ones are slow to add.
constexpr std::uint32_t kItemExponent = 0x40000000u;
struct Item {
  LaneBox box;

  Item(const Box& b, std::uint32_t primitive)
      : box{{b.lower.x, b.lower.y, b.lower.z, std::bit_cast<float>(kItemExponent | primitive)},
            {b.upper.x, b.upper.y, b.upper.z, 0.0f}} {}
  std::uint32_t primitive() const { return std::bit_cast<std::uint32_t>(box.lower[3]) & ~kItemExponent; }
};
static_assert(sizeof(Item) == 32);

struct Bin {
  LaneBox box;
  std::uint32_t count = 0;
};
using AxisBins = std::array<std::array<Bin, kMaxBins>, 3>;

struct Split {
  int axis = -1;  // -1: none found
  std::uint32_t bin = 0;
  float cost = kInf;
};

// A node whose items [begin, end) are still to be split. Its descendants fill the 2 (end − begin − 1) nodes from
// `child` on.
struct Work {
  std::uint32_t node = 0;
  std::uint32_t begin = 0, end = 0;
  std::uint32_t child = 1;
  std::uint32_t depth = 0;
  std::uint32_t count() const { return end - begin; }
};

// Centroid to bin number along each axis.
struct BinMap {
  Lanes origin, scale;
  std::uint32_t bins;

  // Small nodes need fewer planes.
  BinMap(const LaneBox& centroids, const Work& work, const BvhConfig& config)
      : origin(centroids.lower), scale{}, bins(std::min({config.bins, kMaxBins, std::max(4u, 2 * work.count())})) {
    const Lanes extent = centroids.extent();
    // Finite, so that 0 · scale is 0 even if the extent is denormal.
    for (int a = 0; a < 3; ++a)
      scale[a] = extent[a] > 0.0f ? std::min(static_cast<float>(bins) / extent[a], kMax) : 0.0f;
  }
  std::uint32_t operator()(Lanes center, int axis) const {
    const float x = (center[axis] - origin[axis]) * scale[axis];
    return x >= static_cast<float>(bins) ? bins - 1 : static_cast<std::uint32_t>(x);
  }
};

class BvhBuilder {
 public:
  BvhBuilder(const std::vector<Box>& boxes, const std::vector<std::uint32_t>& without, const BvhConfig& config)
      : config_(config) {
    items_.reserve(boxes.size() - without.size());
    // Enough subtrees for every thread, with some to spare because they differ in size.
    together_ = std::max(kLeastTogether, static_cast<std::uint32_t>(items_.capacity() / (4 * thread_count())));
    auto next = without.begin();
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (next != without.end() && *next == i) {
        ++next;
      } else {
        items_.emplace_back(boxes[i], i);
      }
    }
  }

  Bvh build() {
    bvh_.nodes.resize(2 * items_.size() - 1);
    // The upper levels are built one node at a time, each by all threads; then whole subtrees in parallel.
    std::vector<Work> pending{{.end = static_cast<std::uint32_t>(items_.size())}};
    std::vector<Work> subtrees;
    while (!pending.empty()) {
      const Work work = pending.back();
      pending.pop_back();
      if (work.count() <= together_) {
        subtrees.push_back(work);
      } else {
        split_node(work, pending);
      }
    }
    std::ranges::stable_sort(subtrees, std::greater(), &Work::count);  // the last to end should be short
    LongTask progress("Building the tree", items_.size());
    parallel_for(subtrees.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) {
        build_subtree(subtrees[i]);
        progress.advance(subtrees[i].count());
      }
    });
    return std::move(bvh_);
  }

 private:
  void build_subtree(const Work& root) {
    std::vector<Work> pending{root};
    while (!pending.empty()) {
      const Work work = pending.back();
      pending.pop_back();
      split_node(work, pending);
    }
  }

  // Bounds the node, then either makes it a leaf or splits it and queues its children.
  void split_node(const Work& work, std::vector<Work>& pending) {
    BvhNode& node = bvh_.nodes[work.node];
    const auto [box, centroids] = bounds(work);
    node.box = {{box.lower[0], box.lower[1], box.lower[2]}, {box.upper[0], box.upper[1], box.upper[2]}};
    node.leaf = work.count() == 1 ? 1 : 0;
    node.first = node.leaf != 0 ? items_[work.begin].primitive() : work.child;
    if (node.leaf != 0) return;
    const std::uint32_t middle = partition(work, centroids);
    const std::uint32_t left = work.child + 2, right = left + 2 * (middle - work.begin - 1);
    pending.push_back({work.child + 1, middle, work.end, right, work.depth + 1});
    pending.push_back({work.child, work.begin, middle, left, work.depth + 1});
  }

  // Runs body over the node's items, in parallel if it is large. The results of chunks are merged in any order, so they
  // must not depend on it (minima, maxima, counts).
  template <typename State, typename Body, typename Merge>
  State reduce(const Work& work, const State& empty, const Body& body, const Merge& merge) {
    const std::span<const Item> items(items_.data() + work.begin, work.count());
    State total = empty;
    if (work.count() <= together_) {
      body(items, total);
      return total;
    }
    const std::uint64_t grain = kLeastTogether / 4;
    std::vector<State> parts((items.size() + grain - 1) / grain, empty);
    parallel_for(items.size(), grain, [&](std::uint64_t begin, std::uint64_t end) {
      body(items.subspan(begin, end - begin), parts[begin / grain]);
    });
    for (const State& part : parts) merge(total, part);
    return total;
  }

  // Bounds of the items and of their centres.
  std::array<LaneBox, 2> bounds(const Work& work) {
    using Pair = std::array<LaneBox, 2>;
    return reduce(
        work, Pair{},
        [](std::span<const Item> items, Pair& pair) {
          Pair local = pair;
          for (const Item& item : items) {
            const Lanes center = item.box.center();
            local[0].extend(item.box);
            local[1].extend(center, center);
          }
          pair = local;
        },
        [](Pair& a, const Pair& b) {
          a[0].extend(b[0]);
          a[1].extend(b[1]);
        });
  }

  // Partitions the items by the best split and returns the first of the second half.
  std::uint32_t partition(const Work& work, const LaneBox& centroids) {
    if (work.count() == 2) return work.begin + 1;
    const BinMap map(centroids, work, config_);
    const Split split = work.depth < config_.median_depth ? find_split(work, map) : Split{};
    if (split.axis < 0) return median(work, centroids);
    const auto middle = std::partition(items_.begin() + work.begin, items_.begin() + work.end, [&](const Item& item) {
      return map(item.box.center(), split.axis) <= split.bin;
    });
    return static_cast<std::uint32_t>(middle - items_.begin());
  }

  Split find_split(const Work& work, const BinMap& map) {
    if (work.count() > together_) return best_split(bin_together(work, map), map);
    // Each thread has one set of bins for all its nodes, of which only those in use are cleared.
    thread_local AxisBins bins;
    for (auto& axis : bins) std::fill_n(axis.begin(), map.bins, Bin{});
    fill_bins({items_.data() + work.begin, work.count()}, map, bins);
    return best_split(bins, map);
  }

  AxisBins bin_together(const Work& work, const BinMap& map) {
    return reduce(
        work, AxisBins{}, [&map](std::span<const Item> items, AxisBins& bins) { fill_bins(items, map, bins); },
        [&map](AxisBins& a, const AxisBins& b) {
          for (int axis = 0; axis < 3; ++axis) {
            for (std::uint32_t i = 0; i < map.bins; ++i) {
              a[axis][i].box.extend(b[axis][i].box);
              a[axis][i].count += b[axis][i].count;
            }
          }
        });
  }

  static void fill_bins(std::span<const Item> items, const BinMap& map, AxisBins& bins) {
    for (const Item& item : items) {
      const Lanes center = item.box.center();
      for (int a = 0; a < 3; ++a) {
        Bin& bin = bins[a][map(center, a)];
        bin.box.extend(item.box);
        ++bin.count;
      }
    }
  }

  static Split best_split(const AxisBins& bins, const BinMap& map) {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      if (map.scale[axis] > 0.0f) sweep(bins[axis], map.bins, axis, best);
    }
    return best;
  }

  static void sweep(const std::array<Bin, kMaxBins>& bins, std::uint32_t count, int axis, Split& best) {
    std::array<float, kMaxBins> right_cost;
    LaneBox box;
    std::uint32_t n = 0;
    for (std::uint32_t i = count - 1; i > 0; --i) {
      box.extend(bins[i].box);
      n += bins[i].count;
      right_cost[i] = n > 0 ? box.half_area() * static_cast<float>(n) : 0.0f;
    }
    const std::uint32_t total = n + bins[0].count;
    box = {};
    n = 0;
    for (std::uint32_t i = 0; i + 1 < count; ++i) {
      box.extend(bins[i].box);
      n += bins[i].count;
      if (n == 0 || n == total) continue;
      const float cost = box.half_area() * static_cast<float>(n) + right_cost[i + 1];
      if (cost < best.cost) best = {axis, i, cost};
    }
  }

  // Halves the items along the longest axis of their centres.
  std::uint32_t median(const Work& work, const LaneBox& centroids) {
    const Lanes extent = centroids.extent();
    const int axis = extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : extent[1] >= extent[2] ? 1 : 2;
    const std::uint32_t middle = work.begin + work.count() / 2;
    std::nth_element(items_.begin() + work.begin, items_.begin() + middle, items_.begin() + work.end,
                     [axis](const Item& a, const Item& b) {
                       const float ca = a.box.center()[axis], cb = b.box.center()[axis];
                       return ca != cb ? ca < cb : a.primitive() < b.primitive();
                     });
    return middle;
  }

  BvhConfig config_;
  std::vector<Item> items_;
  std::uint32_t together_;  // items of nodes that are split by all threads together; smaller ones are by one
  Bvh bvh_;
};

}  // namespace

Bvh build_bvh(std::vector<Box> boxes, const std::vector<std::uint32_t>& without, const BvhConfig& config) {
  BvhBuilder builder(boxes, without, config);
  release(boxes);  // the memory is needed for the nodes
  return builder.build();
}

}  // namespace etendue
