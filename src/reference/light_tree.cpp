#include "reference/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "reference/rng.h"

namespace etendue::reference {
namespace {

constexpr std::uint32_t kMaxLevels = 31;
constexpr std::uint32_t kLevelsPerWord = 6;

/// The number that decides at `level`: every sixth level uses a fresh one, so that stretching does not magnify rounding
/// errors further.
double fresh_number(std::uint32_t level, std::uint32_t word_a, std::uint32_t word_b) {
  if (level == 0) return unit_float(word_a);
  if (level == kLevelsPerWord) return unit_float(word_b);
  return unit_float(hashed_word(level, word_b));
}

}  // namespace

std::uint32_t hashed_word(std::uint32_t level, std::uint32_t word_b) {
  std::uint32_t x = word_b + level * 0x9e3779b9u;
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

/// Coordinates of a leaf in the space that is split: the centre of its box and its normal, as integers, so that the
/// tree is the same everywhere.
struct LightTree::Key {
  std::array<std::int32_t, 6> q{};
  LightLeaf leaf;
};

LightTree::LightTree(std::vector<LightLeaf> leaves) {
  if (leaves.empty()) return;
  Vec3 lower(INFINITY), upper(-INFINITY);
  for (const LightLeaf& leaf : leaves) {
    lower = glm::min(lower, 0.5 * (leaf.lower + leaf.upper));
    upper = glm::max(upper, 0.5 * (leaf.lower + leaf.upper));
  }
  const double extent = max_component(upper - lower);
  std::vector<Key> keys;
  keys.reserve(leaves.size());
  for (const LightLeaf& leaf : leaves) {
    Key key;
    for (int axis = 0; axis < 3; ++axis) {
      const double center = 0.5 * (leaf.lower[axis] + leaf.upper[axis]);
      if (extent > 0.0)
        key.q[axis] = static_cast<std::int32_t>(std::floor((center - lower[axis]) / extent * 65535.0 + 0.5));
      key.q[axis + 3] = static_cast<std::int32_t>(std::floor(leaf.normal[axis] * 8192.0 + 0.5));
    }
    key.leaf = leaf;
    keys.push_back(key);
  }
  leaves_ = std::move(leaves);
  nodes_.reserve(2 * leaves_.size());
  build(0, static_cast<std::uint32_t>(leaves_.size()), 0, keys);
}

std::uint32_t LightTree::build(std::uint32_t first, std::uint32_t count, std::uint32_t level, std::vector<Key>& keys) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  const auto begin = keys.begin() + first, end = begin + count;
  std::uint32_t left_count = 0;
  if (count > 1) {
    std::array<std::int32_t, 6> least = begin->q, most = begin->q;
    for (auto key = begin; key != end; ++key) {
      for (std::size_t a = 0; a < 6; ++a) {
        least[a] = std::min(least[a], key->q[a]);
        most[a] = std::max(most[a], key->q[a]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < 6; ++a) {
      if (most[a] - least[a] > most[axis] - least[axis]) axis = a;
    }
    const bool may_be_uneven = level + std::bit_width(count - 1) < kMaxLevels;
    if (most[axis] > least[axis] && may_be_uneven) {
      const std::int32_t middle = least[axis] + (most[axis] - least[axis]) / 2;
      const auto right = std::stable_partition(begin, end, [&](const Key& key) { return key.q[axis] <= middle; });
      left_count = static_cast<std::uint32_t>(right - begin);
    } else {
      left_count = count / 2;
    }
  } else {
    leaves_[first] = begin->leaf;
    places_[{begin->leaf.light, begin->leaf.primitive}] = first;
  }
  std::uint32_t left = 0, right = 0;
  if (count > 1) {
    left = build(first, left_count, level + 1, keys);
    right = build(first + left_count, count - left_count, level + 1, keys);
  }
  nodes_[index] = bound(first, count);
  nodes_[index].left = left;
  nodes_[index].right = right;
  return index;
}

LightTree::Node LightTree::bound(std::uint32_t first, std::uint32_t count) const {
  Node node{.leaf = first, .count = count};
  Vec3 lower(INFINITY), upper(-INFINITY), sum(0.0);
  for (std::uint32_t i = first; i < first + count; ++i) {
    lower = glm::min(lower, leaves_[i].lower);
    upper = glm::max(upper, leaves_[i].upper);
    node.power += leaves_[i].power;
    sum += leaves_[i].power * leaves_[i].normal;
  }
  node.center = 0.5 * (lower + upper);
  node.radius = 0.5 * glm::length(upper - lower);
  // If the normals cancel, the direction of their sum is rounding error, so there is no cone.
  const double length = glm::length(sum);
  const bool directed = length > 1e-3 * node.power;
  node.axis = directed ? sum / length : Vec3(0.0, 0.0, 1.0);
  node.cos_cone = directed ? 1.0 : -1.0;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const bool all_sides = leaves_[i].normal == Vec3(0.0);
    const double to_axis = glm::dot(node.axis, leaves_[i].normal);
    // A leaf with a cone of its own extends further from the axis.
    const double angle = std::acos(std::clamp(to_axis, -1.0, 1.0)) + std::acos(leaves_[i].cos_cone);
    const double farthest = leaves_[i].cos_cone == 1.0 ? to_axis : angle >= kPi ? -1.0 : std::cos(angle);
    node.cos_cone = std::min(node.cos_cone, all_sides ? -1.0 : farthest);
    // A cap wider than a half sphere is not convex: it may miss normals between the corners'.
    for (const Vec3& corner : leaves_[i].corner_normals)
      node.cos_cone = std::min(node.cos_cone, glm::dot(node.axis, corner) < 0.0 ? -1.0 : glm::dot(node.axis, corner));
  }
  return node;
}

double LightTree::importance(const Node& node, const Vec3& p, const Vec3& n) {
  const Vec3 to_center = node.center - p;
  const double d = glm::length(to_center);
  const double reach = node.radius + 1e-5 * d;
  const auto usual_height = [&](double of_center) {
    return of_center + reach > 0.0 ? std::max(of_center + 0.7 * reach, 0.1 * reach) : 0.0;
  };
  const double angle = std::acos(d > 0.0 ? std::clamp(-glm::dot(node.axis, to_center) / d, -1.0, 1.0) : 1.0);
  const double above_light = d * std::cos(std::max(0.0, angle - std::acos(node.cos_cone)));
  // Without a normal, light from both sides counts, whatever its angle to the surface.
  const double above_surface = n == Vec3(0.0) ? d : glm::dot(n, to_center);
  const double distance2 = d * d + 0.35 * node.radius * node.radius;
  return node.power * usual_height(above_light) * usual_height(above_surface) / (distance2 * distance2);
}

double LightTree::left_share(const Node& node, const Vec3& p, const Vec3& n) const {
  const double left = importance(nodes_[node.left], p, n), right = importance(nodes_[node.right], p, n);
  return left + right > 0.0 ? left / (left + right) : -1.0;
}

LightTree::Choice LightTree::choose(const Vec3& p, const Vec3& n, std::uint32_t word_a, std::uint32_t word_b) const {
  const Node* node = &nodes_.front();
  double prob = 1.0, u = 0.0;
  for (std::uint32_t level = 0; node->count > 1; ++level) {
    if (level % kLevelsPerWord == 0) u = fresh_number(level, word_a, word_b);
    const double share = left_share(*node, p, n);
    if (share < 0.0) return {};
    const bool left = u < share;
    u = std::min(left ? u / share : (u - share) / (1.0 - share), 1.0 - 0x1p-24);
    prob *= left ? share : 1.0 - share;
    node = &nodes_[left ? node->left : node->right];
  }
  return {&leaves_[node->leaf], prob};
}

double LightTree::prob(const Vec3& p, const Vec3& n, std::uint32_t light, std::uint32_t primitive) const {
  const auto found = places_.find({light, primitive});
  if (found == places_.end()) return 0.0;
  const Node* node = &nodes_.front();
  double prob = 1.0;
  while (node->count > 1) {
    const double share = left_share(*node, p, n);
    if (share < 0.0) return 0.0;
    const bool left = found->second < nodes_[node->right].leaf;
    prob *= left ? share : 1.0 - share;
    node = &nodes_[left ? node->left : node->right];
  }
  return prob;
}

}  // namespace etendue::reference
