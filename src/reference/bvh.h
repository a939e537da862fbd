#pragma once
/// Binary bounding volume hierarchy with double-precision boxes.

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "reference/ray.h"

namespace etendue::reference {

/// Axis-aligned box; empty when new.
struct Box {
  Vec3 lo{std::numeric_limits<double>::infinity()};
  Vec3 hi{-std::numeric_limits<double>::infinity()};

  void include(const Vec3& p) {
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  void include(const Box& box) {
    lo = glm::min(lo, box.lo);
    hi = glm::max(hi, box.hi);
  }
  /// Half the surface area, to which the probability of a random ray hitting the box is proportional.
  double half_area() const {
    const Vec3 d = hi - lo;
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }
};

class Bvh {
 public:
  /// Builds by binned surface area heuristic [Wald2007]. Primitive i has boxes[i].
  explicit Bvh(const std::vector<Box>& boxes);
  Bvh() = default;

  /// Position → primitive: leaves are ranges of this order.
  const std::vector<std::uint32_t>& order() const { return order_; }

  /// Calls `visit(position, t_max)` for the positions in `order()` whose boxes the ray meets before t_max, near boxes
  /// first. `visit` may lower t_max; returning true ends the traversal. Returns whether `visit` ended it.
  template <class Visit>
  bool traverse(const Ray& ray, Visit&& visit) const;

 private:
  struct Node {
    Box box;
    std::uint32_t first = 0;  ///< leaf: first position; inner node: its children are `first` and `first + 1`
    std::uint32_t count = 0;  ///< leaf: number of primitives; inner node: 0
  };
  /// Bounds the depth, and with it the traversal stack: below kSahDepth, nodes are halved.
  static constexpr int kSahDepth = 64;
  static constexpr int kMaxDepth = kSahDepth + 33;

  struct Item;
  void build(std::vector<Item>& items);

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

/// Slab test: the entry distance, or infinity if the box is missed. The far distance is widened by the rounding errors
/// of this computation [Ize2013]; comparisons are written so that the NaN of 0 · ∞ (a ray in the plane of a face)
/// counts as "inside".
inline double enter_box(const Box& box, const Vec3& origin, const Vec3& inverse, double t_min, double t_max) {
  for (int axis = 0; axis < 3; ++axis) {
    const bool positive = inverse[axis] >= 0.0;
    const double t_near = ((positive ? box.lo : box.hi)[axis] - origin[axis]) * inverse[axis];
    const double t_far = ((positive ? box.hi : box.lo)[axis] - origin[axis]) * inverse[axis] * (1.0 + 0x1p-50);
    if (t_near > t_min) t_min = t_near;
    if (t_far < t_max) t_max = t_far;
  }
  return t_min <= t_max ? t_min : std::numeric_limits<double>::infinity();
}

template <class Visit>
bool Bvh::traverse(const Ray& ray, Visit&& visit) const {
  if (nodes_.empty()) return false;
  constexpr double kMissed = std::numeric_limits<double>::infinity();
  const Vec3 inverse = 1.0 / ray.direction;
  double t_max = ray.t_max;
  struct Entry {
    std::uint32_t node;
    double t;
  };
  std::array<Entry, kMaxDepth + 1> stack;
  int size = 0;
  // Apart from rounding, a ray enters a box before it hits anything inside; of surfaces at the same distance, all are
  // visited.
  constexpr double kSlack = 1.0 + 0x1p-40;
  const auto enter = [&](std::uint32_t node) {
    return enter_box(nodes_[node].box, ray.origin, inverse, ray.t_min / kSlack, t_max * kSlack);
  };
  if (const double t = enter(0); t != kMissed) stack[size++] = {0, t};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.t > t_max * kSlack) continue;
    const Node& node = nodes_[entry.node];
    if (node.count > 0) {
      for (std::uint32_t i = 0; i < node.count; ++i)
        if (visit(node.first + i, t_max)) return true;
      continue;
    }
    Entry near{node.first, enter(node.first)};
    Entry far{node.first + 1, enter(node.first + 1)};
    if (far.t < near.t) std::swap(near, far);
    if (far.t != kMissed) stack[size++] = far;
    if (near.t != kMissed) stack[size++] = near;
  }
  return false;
}

}  // namespace etendue::reference
