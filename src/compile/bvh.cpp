#include "compile/bvh.h"

#include <array>
#include <numeric>
#include <span>

#include "core/parallel.h"

namespace etendue {
namespace {

constexpr std::uint32_t kMaxBins = 64;
constexpr std::uint32_t kParallelBinning = 1u << 16;  // nodes at least this large are binned by several threads
constexpr std::uint32_t kSubtree = 1u << 12;          // nodes at most this large are built by one thread, whole

struct Bin {
  Box box;
  std::uint32_t count = 0;
};
using AxisBins = std::array<std::array<Bin, kMaxBins>, 3>;

struct Split {
  int axis = -1;  // -1: none found
  std::uint32_t bin = 0;
  float cost = std::numeric_limits<float>::infinity();
};

// A node whose primitives order[begin, end) are still to be split.
struct Work {
  std::uint32_t node = 0;
  std::uint32_t begin = 0, end = 0;
  std::uint32_t depth = 0;
};

// Centroid to bin number along each axis.
struct BinMap {
  glm::vec3 origin{0.0f}, scale{0.0f};
  BinMap(const Box& centroids, std::uint32_t bins) : origin(centroids.lower) {
    for (int a = 0; a < 3; ++a) {
      const float extent = centroids.upper[a] - centroids.lower[a];
      scale[a] = extent > 0.0f ? static_cast<float>(bins) / extent : 0.0f;
    }
  }
  std::uint32_t operator()(const glm::vec3& c, int axis, std::uint32_t bins) const {
    const float x = (c[axis] - origin[axis]) * scale[axis];
    return x >= static_cast<float>(bins) ? bins - 1
                                         : static_cast<std::uint32_t>(x);  // extents near 0 may overflow to inf
  }
};

class Builder {
 public:
  Builder(const std::vector<Box>& boxes, const BvhConfig& config)
      : boxes_(boxes), config_(config), order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
  }

  Bvh build() {
    // The upper levels one node at a time, each with all threads; then whole subtrees side by side.
    std::vector<BvhBuildNode> top(1);
    std::vector<Work> pending{{0, 0, static_cast<std::uint32_t>(boxes_.size()), 0}};
    std::vector<Work> subtrees;
    while (!pending.empty()) {
      const Work work = pending.back();
      pending.pop_back();
      if (work.end - work.begin <= kSubtree) {
        subtrees.push_back(work);
      } else {
        split_node(top, work, pending);
      }
    }
    std::vector<std::vector<BvhBuildNode>> built(subtrees.size());
    parallel_for(subtrees.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) built[i] = build_subtree(subtrees[i]);
    });
    return assemble(top, subtrees, built);
  }

 private:
  std::vector<BvhBuildNode> build_subtree(const Work& root) {
    std::vector<BvhBuildNode> nodes(1);
    std::vector<Work> pending{{0, root.begin, root.end, root.depth}};
    while (!pending.empty()) {
      const Work work = pending.back();
      pending.pop_back();
      split_node(nodes, work, pending);
    }
    return nodes;
  }

  // Bounds the node, then either makes it a leaf or splits it and queues its children.
  void split_node(std::vector<BvhBuildNode>& nodes, const Work& work, std::vector<Work>& pending) {
    const std::uint32_t count = work.end - work.begin;
    Box box, centroids;
    bounds(work, box, centroids);
    nodes[work.node].box = box;
    const Split split = work.depth < config_.median_depth ? find_split(work, centroids) : Split{};
    const float leaf_cost = static_cast<float>(count);
    const float split_cost =
        config_.traversal_cost + split.cost / std::max(box.half_area(), std::numeric_limits<float>::min());
    if (count == 1 || (count <= config_.max_leaf && (split.axis < 0 || leaf_cost <= split_cost))) {
      nodes[work.node].first = work.begin;
      nodes[work.node].count = count;
      return;
    }
    const std::uint32_t middle = split.axis >= 0 ? partition(work, split, centroids) : median(work, centroids);
    const auto child = static_cast<std::uint32_t>(nodes.size());
    nodes[work.node].first = child;
    nodes.resize(nodes.size() + 2);
    pending.push_back({child + 1, middle, work.end, work.depth + 1});
    pending.push_back({child, work.begin, middle, work.depth + 1});
  }

  // Runs body over chunks of the node's primitives, in parallel when it is large; results are merged by the caller in
  // any order, so they must be order-free (minima, maxima, counts).
  template <typename State, typename Body, typename Merge>
  State reduce(const Work& work, const Body& body, const Merge& merge) {
    const std::uint32_t count = work.end - work.begin;
    const std::span<const std::uint32_t> items(order_.data() + work.begin, count);
    State total{};
    if (count < kParallelBinning) {
      body(items, total);
      return total;
    }
    const std::uint64_t grain = kParallelBinning / 4;
    std::vector<State> parts((count + grain - 1) / grain);
    parallel_for(count, grain, [&](std::uint64_t begin, std::uint64_t end) {
      body(items.subspan(begin, end - begin), parts[begin / grain]);
    });
    for (const State& part : parts) merge(total, part);
    return total;
  }

  void bounds(const Work& work, Box& box, Box& centroids) {
    using Pair = std::array<Box, 2>;
    const Pair both = reduce<Pair>(
        work,
        [&](std::span<const std::uint32_t> items, Pair& pair) {
          for (const std::uint32_t i : items) {
            pair[0].extend(boxes_[i]);
            pair[1].extend(boxes_[i].center());
          }
        },
        [](Pair& a, const Pair& b) {
          a[0].extend(b[0]);
          a[1].extend(b[1]);
        });
    box = both[0];
    centroids = both[1];
  }

  std::uint32_t bin_count(const Work& work) const {
    // Small nodes do not need many planes.
    return std::min({config_.bins, kMaxBins, std::max(4u, 2 * (work.end - work.begin))});
  }

  Split find_split(const Work& work, const Box& centroids) {
    const std::uint32_t bins = bin_count(work);
    const BinMap map(centroids, bins);
    const AxisBins binned = reduce<AxisBins>(
        work,
        [&](std::span<const std::uint32_t> items, AxisBins& out) {
          for (const std::uint32_t i : items) {
            const glm::vec3 c = boxes_[i].center();
            for (int a = 0; a < 3; ++a) {
              Bin& bin = out[a][map(c, a, bins)];
              bin.box.extend(boxes_[i]);
              ++bin.count;
            }
          }
        },
        [bins](AxisBins& a, const AxisBins& b) {
          for (int axis = 0; axis < 3; ++axis) {
            for (std::uint32_t i = 0; i < bins; ++i) {
              a[axis][i].box.extend(b[axis][i].box);
              a[axis][i].count += b[axis][i].count;
            }
          }
        });
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      if (centroids.upper[axis] > centroids.lower[axis]) sweep(binned[axis], bins, axis, best);
    }
    return best;
  }

  static void sweep(const std::array<Bin, kMaxBins>& bins, std::uint32_t count, int axis, Split& best) {
    std::array<float, kMaxBins> right_cost{};
    Box box;
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

  std::uint32_t partition(const Work& work, const Split& split, const Box& centroids) {
    const std::uint32_t bins = bin_count(work);
    const BinMap map(centroids, bins);
    const auto middle = std::partition(order_.begin() + work.begin, order_.begin() + work.end, [&](std::uint32_t i) {
      return map(boxes_[i].center(), split.axis, bins) <= split.bin;
    });
    return static_cast<std::uint32_t>(middle - order_.begin());
  }

  std::uint32_t median(const Work& work, const Box& centroids) {
    const glm::vec3 extent = centroids.upper - centroids.lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::uint32_t middle = work.begin + (work.end - work.begin) / 2;
    std::nth_element(order_.begin() + work.begin, order_.begin() + middle, order_.begin() + work.end,
                     [&](std::uint32_t a, std::uint32_t b) {
                       const float ca = boxes_[a].center()[axis], cb = boxes_[b].center()[axis];
                       return ca != cb ? ca < cb : a < b;
                     });
    return middle;
  }

  // Lays the tree out depth first, which is the same whatever order it was built in.
  Bvh assemble(const std::vector<BvhBuildNode>& top, const std::vector<Work>& subtrees,
               const std::vector<std::vector<BvhBuildNode>>& built) {
    std::vector<std::uint32_t> subtree_of(top.size(), ~0u);
    for (std::uint32_t i = 0; i < subtrees.size(); ++i) subtree_of[subtrees[i].node] = i;
    struct Place {
      const std::vector<BvhBuildNode>* from;
      std::uint32_t index, target, depth;
    };
    Bvh bvh;
    bvh.order = std::move(order_);
    bvh.nodes.resize(1);
    std::vector<Place> pending{{&top, 0, 0, 0}};
    while (!pending.empty()) {
      Place place = pending.back();
      pending.pop_back();
      if (place.from == &top && subtree_of[place.index] != ~0u) {
        place.from = &built[subtree_of[place.index]];
        place.index = 0;
      }
      const BvhBuildNode& node = (*place.from)[place.index];
      bvh.nodes[place.target] = node;
      if (node.count > 0) {
        bvh.depth = std::max(bvh.depth, place.depth);
        continue;
      }
      const auto child = static_cast<std::uint32_t>(bvh.nodes.size());
      bvh.nodes[place.target].first = child;
      bvh.nodes.resize(bvh.nodes.size() + 2);
      pending.push_back({place.from, node.first + 1, child + 1, place.depth + 1});
      pending.push_back({place.from, node.first, child, place.depth + 1});
    }
    return bvh;
  }

  const std::vector<Box>& boxes_;
  BvhConfig config_;
  std::vector<std::uint32_t> order_;
};

}  // namespace

Bvh build_bvh(const std::vector<Box>& boxes, const BvhConfig& config) {
  return Builder(boxes, config).build();
}

}  // namespace etendue
