#include "reference/bvh.h"

#include <algorithm>

namespace etendue::reference {

struct Bvh::Item {
  Box box;
  Vec3 center{0.0};
  std::uint32_t primitive = 0;
};

namespace {

constexpr int kBins = 16;
constexpr std::size_t kLeafSize = 4;

/// Half-open bins along one axis; the upper end belongs to the last one.
struct Binning {
  int axis;
  double lo, scale;
  int bin(const Vec3& center) const { return std::clamp(static_cast<int>((center[axis] - lo) * scale), 0, kBins - 1); }
};

/// Index of the first bin on the right side of the split with the least cost by the surface-area heuristic, and that
/// cost, in primitive tests times the parent's half area.
template <class Iterator>
std::pair<int, double> best_split(Iterator begin, Iterator end, const Binning& binning) {
  std::array<Box, kBins> box;
  std::array<double, kBins> count{};
  for (auto item = begin; item != end; ++item) {
    const int bin = binning.bin(item->center);
    box[bin].include(item->box);
    count[bin] += 1.0;
  }
  std::array<double, kBins> right_cost{};
  Box right;
  double right_count = 0.0;
  for (int i = kBins - 1; i > 0; --i) {
    right.include(box[i]);
    right_count += count[i];
    right_cost[i] = right_count > 0.0 ? right_count * right.half_area() : 0.0;
  }
  std::pair<int, double> best{0, std::numeric_limits<double>::infinity()};
  Box left;
  double left_count = 0.0;
  for (int i = 1; i < kBins; ++i) {
    left.include(box[i - 1]);
    left_count += count[i - 1];
    if (left_count == 0.0 || left_count == static_cast<double>(end - begin)) continue;
    const double cost = left_count * left.half_area() + right_cost[i];
    if (cost < best.second) best = {i, cost};
  }
  return best;
}

/// Splits [begin, end) and returns the middle, or `begin` if it should be a leaf.
template <class Iterator>
Iterator split(Iterator begin, Iterator end, const Box& bounds, bool halve) {
  const auto count = static_cast<std::size_t>(end - begin);
  if (count <= 1) return begin;
  Box centers;
  for (auto item = begin; item != end; ++item) centers.include(item->center);
  const Vec3 extent = centers.hi - centers.lo;
  const int axis = extent.x > extent.y ? (extent.x > extent.z ? 0 : 2) : (extent.y > extent.z ? 1 : 2);
  if (!halve && extent[axis] > 0.0) {
    const Binning binning{axis, centers.lo[axis], kBins / extent[axis]};
    const auto [first_right, cost] = best_split(begin, end, binning);
    const double leaf_cost = (static_cast<double>(count) - 1.0) * bounds.half_area();  // a step costs about one test
    if (count <= kLeafSize && leaf_cost <= cost) return begin;
    if (first_right > 0)
      return std::partition(begin, end,
                            [&, first = first_right](const auto& item) { return binning.bin(item.center) < first; });
  }
  if (count <= kLeafSize) return begin;
  const auto middle = begin + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(begin, middle, end,
                   [axis](const auto& a, const auto& b) { return a.center[axis] < b.center[axis]; });
  return middle;
}

}  // namespace

Bvh::Bvh(const std::vector<Box>& boxes) {
  std::vector<Item> items(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    items[i] = {boxes[i], 0.5 * boxes[i].lo + 0.5 * boxes[i].hi, static_cast<std::uint32_t>(i)};
  if (!items.empty()) build(items);
}

void Bvh::build(std::vector<Item>& items) {
  struct Task {
    std::size_t begin, end;
    std::uint32_t node;
    int depth;
  };
  nodes_.emplace_back();
  std::vector<Task> tasks{{0, items.size(), 0, 0}};
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const auto begin = items.begin() + static_cast<std::ptrdiff_t>(task.begin);
    const auto end = items.begin() + static_cast<std::ptrdiff_t>(task.end);
    Box bounds;
    for (auto item = begin; item != end; ++item) bounds.include(item->box);
    nodes_[task.node].box = bounds;
    const auto middle = split(begin, end, bounds, task.depth >= kSahDepth);
    if (middle == begin) {
      nodes_[task.node].first = static_cast<std::uint32_t>(task.begin);
      nodes_[task.node].count = static_cast<std::uint32_t>(task.end - task.begin);
      continue;
    }
    const auto left = static_cast<std::uint32_t>(nodes_.size());
    nodes_[task.node].first = left;
    nodes_.resize(nodes_.size() + 2);
    const auto at = static_cast<std::size_t>(middle - items.begin());
    tasks.push_back({task.begin, at, left, task.depth + 1});
    tasks.push_back({at, task.end, left + 1, task.depth + 1});
  }
  order_.reserve(items.size());
  for (const Item& item : items) order_.push_back(item.primitive);
}

}  // namespace etendue::reference
