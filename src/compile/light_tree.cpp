#include "compile/light_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace etendue {
namespace {

using Index = std::uint32_t;
using Corner = std::array<std::int32_t, 6>;  // centre and normal of a leaf in integers

// In choosing the axis, opposite normals count as much as an eighth of the extent of all lights.
constexpr double kCenterSteps = 65535.0;
constexpr double kNormalSteps = 8192.0;

std::int32_t nearest_step(double x) {
  return static_cast<std::int32_t>(std::floor(x + 0.5));
}

std::vector<Corner> quantise(const std::vector<LightLeaf>& leaves) {
  const auto center = [](const LightLeaf& leaf) { return 0.5 * (leaf.lower + leaf.upper); };
  glm::dvec3 lower = center(leaves.front()), upper = lower;
  for (const LightLeaf& leaf : leaves) {
    lower = glm::min(lower, center(leaf));
    upper = glm::max(upper, center(leaf));
  }
  const glm::dvec3 size = upper - lower;
  const double extent = std::max({size.x, size.y, size.z});
  std::vector<Corner> corners(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    for (int a = 0; a < 3; ++a) {
      corners[i][a] = extent > 0.0 ? nearest_step((center(leaves[i])[a] - lower[a]) / extent * kCenterSteps) : 0;
      corners[i][a + 3] = nearest_step(leaves[i].normal[a] * kNormalSteps);
    }
  }
  return corners;
}

// Cosine of the largest angle between the axis and the leaf's normals.
double farthest_cosine(const glm::dvec3& axis, const LightLeaf& leaf) {
  const double c = glm::dot(axis, leaf.normal);
  if (leaf.cos_cone == 1.0) return c;
  if (c + leaf.cos_cone <= 0.0) return -1.0;
  const double across = std::max(0.0, 1.0 - c * c) * std::max(0.0, 1.0 - leaf.cos_cone * leaf.cos_cone);
  return c * leaf.cos_cone - std::sqrt(across);
}

class LightTreeBuilder {
 public:
  LightTreeBuilder(const std::vector<LightLeaf>& leaves, const Normalization& normalization)
      : leaves_(leaves), normalization_(normalization), corners_(quantise(leaves)), order_(leaves.size()) {
    std::iota(order_.begin(), order_.end(), Index{0});
    for (const LightLeaf& leaf : leaves) total_power_ += leaf.power;
  }

  FlatLightTree build() {
    out_.trails.resize(leaves_.size());
    branch(0, static_cast<Index>(order_.size()), 0, 0);
    return std::move(out_);
  }

 private:
  // Makes the half of a pair for order_[first, first + count), `level` turns below the root; returns the reference to
  // it.
  Index half(Index first, Index count, Index level, Index turns) {
    if (count > 1) return branch(first, count, level, turns);
    const LightLeaf& leaf = leaves_[order_[first]];
    const double area = leaf.area * normalization_.scale * normalization_.scale;
    out_.trails[order_[first]] = {turns | Index{1} << level, static_cast<float>(area), 0, 0};
    out_.depth = std::max(out_.depth, level);
    return gpu::kLightLeaf | leaf.light_primitive;
  }

  // Makes the pair of order_[first, first + count) and returns its index.
  Index branch(Index first, Index count, Index level, Index turns) {
    const auto index = static_cast<Index>(out_.pairs.size());
    out_.pairs.emplace_back();
    const Index left = split(first, count, level);
    gpu::LightPair pair{};
    pair.left_bounds = bounds(first, left, pair.left_power);
    pair.right_bounds = bounds(first + left, count - left, pair.right_power);
    pair.left = half(first, left, level + 1, turns);
    pair.right = half(first + left, count - left, level + 1, turns | Index{1} << level);
    out_.pairs[index] = pair;
    return index;
  }

  // Reorders the leaves and returns how many go left, by cutting the widest of the six axes in its middle. If all
  // leaves coincide, or the tree would become too deep, half of them go left.
  Index split(Index first, Index count, Index level) {
    const auto begin = order_.begin() + first, end = begin + count;
    Corner least = corners_[*begin], most = least;
    for (auto i = begin; i != end; ++i) {
      for (std::size_t a = 0; a < least.size(); ++a) {
        least[a] = std::min(least[a], corners_[*i][a]);
        most[a] = std::max(most[a], corners_[*i][a]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t a = 1; a < least.size(); ++a) {
      if (most[a] - least[a] > most[axis] - least[axis]) axis = a;
    }
    const Index levels_needed = static_cast<Index>(std::bit_width(count - 1));
    if (most[axis] == least[axis] || level + levels_needed >= gpu::kMaxLightTreeDepth) return count / 2;
    const std::int32_t middle = least[axis] + (most[axis] - least[axis]) / 2;
    const auto right = std::stable_partition(begin, end, [&](Index i) { return corners_[i][axis] <= middle; });
    return static_cast<Index>(right - begin);
  }

  gpu::LightBounds bounds(Index first, Index count, float& power_share) const {
    glm::dvec3 lower(std::numeric_limits<double>::infinity()), upper(-lower), sum(0.0);
    double power = 0.0;
    for (Index i = first; i < first + count; ++i) {
      const LightLeaf& leaf = leaves_[order_[i]];
      lower = glm::min(lower, leaf.lower);
      upper = glm::max(upper, leaf.upper);
      power += leaf.power;
      sum += leaf.power * leaf.normal;
    }
    const double length = glm::length(sum);
    const bool directed =
        length > 1e-3 * power;  // otherwise the normals cancel, and the direction of their sum is rounding error
    const glm::dvec3 axis = directed ? sum / length : glm::dvec3(0.0, 0.0, 1.0);
    double cosine = directed ? 1.0 : -1.0;
    for (Index i = first; i < first + count; ++i) {
      const LightLeaf& leaf = leaves_[order_[i]];
      cosine = std::min(cosine, leaf.normal == glm::dvec3(0.0) ? -1.0 : farthest_cosine(axis, leaf));
      for (const glm::dvec3& normal : leaf.corner_normals) {
        const double c = glm::dot(axis, normal);
        // A cone wider than a right angle does not contain all normals in between.
        cosine = std::min(cosine, c < 0.0 ? -1.0 : c);
      }
    }
    power_share = static_cast<float>(power / total_power_);
    return {.center = normalization_.point(0.5 * (lower + upper)),
            .radius = static_cast<float>(0.5 * glm::length(upper - lower) * normalization_.scale),
            .axis = glm::vec3(axis),
            .cos_cone = static_cast<float>(cosine)};
  }

  const std::vector<LightLeaf>& leaves_;
  const Normalization& normalization_;
  std::vector<Corner> corners_;
  std::vector<Index> order_;
  double total_power_ = 0.0;
  FlatLightTree out_;
};

}  // namespace

FlatLightTree build_light_tree(const std::vector<LightLeaf>& leaves, const Normalization& normalization) {
  return LightTreeBuilder(leaves, normalization).build();
}

}  // namespace etendue
