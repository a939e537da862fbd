#include "compile/few_primitives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "gpu_types.h"

namespace etendue {
namespace {

// Costs in steps of the walk, a step being a fetch of one record and its intersection. A primitive outside the tree is
// a handful of multiplications with constants, the same for all lanes.
constexpr double kTestOutside = 0.1;
// A large primitive in the tree costs every ray that meets its box one step, and most of another for a node above it.
constexpr double kTestInside = 2.0;
// A ray that meets the box of a tree of n primitives takes about this times log2 n steps (measured on meshes of 10^5 to
// 10^6 triangles).
constexpr double kStepsPerDoubling = 1.2;

// The largest boxes, largest first.
std::vector<std::uint32_t> largest(const std::vector<Box>& boxes, std::size_t eligible, std::size_t count) {
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const float area_a = boxes[a].half_area(), area_b = boxes[b].half_area();
    return area_a != area_b ? area_a > area_b : a < b;
  };
  std::vector<std::uint32_t> largest;
  largest.reserve(count + 1);
  for (std::uint32_t i = 0; i < eligible; ++i) {
    if (largest.size() == count && !before(i, largest.back())) continue;
    largest.insert(std::upper_bound(largest.begin(), largest.end(), i, before), i);
    if (largest.size() > count) largest.pop_back();
  }
  return largest;
}

}  // namespace

std::vector<std::uint32_t> choose_few_primitives(const std::vector<Box>& boxes, std::size_t eligible) {
  std::vector<std::uint32_t> candidates = largest(boxes, std::min(eligible, boxes.size()), gpu::kFewPrimitives);
  if (boxes.size() > candidates.size()) {
    Box rest;
    std::vector<bool> is_candidate(boxes.size(), false);
    for (const std::uint32_t i : candidates) is_candidate[i] = true;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (!is_candidate[i]) rest.extend(boxes[i]);
    }
    Box all = rest;
    for (const std::uint32_t i : candidates) all.extend(boxes[i]);
    // Moves candidates into the tree one by one; `inside` is the cost of those already there.
    const double steps = kStepsPerDoubling * std::log2(static_cast<double>(boxes.size()));
    const double whole = std::max(double{all.half_area()}, 1e-30);
    double lowest = INFINITY, inside = 0.0;
    std::size_t best = 0;
    for (std::size_t outside = candidates.size();; --outside) {
      const double cost = kTestOutside * static_cast<double>(outside) + steps * rest.half_area() / whole + inside;
      if (cost <= lowest) lowest = cost, best = outside;
      if (outside == 0) break;
      const Box& next = boxes[candidates[outside - 1]];
      rest.extend(next);
      inside += kTestInside * next.half_area() / whole;
    }
    candidates.resize(best);
  }
  std::ranges::sort(candidates);
  return candidates;
}

}  // namespace etendue
