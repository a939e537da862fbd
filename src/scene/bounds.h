#pragma once
/// Boxes around what a scene holds.

#include <limits>

#include "scene/scene.h"

namespace etendue {

/// Axis-aligned box in world space; empty when new.
struct Bounds {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  void add(const glm::dvec3& p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  bool empty() const { return !(min.x <= max.x); }
};

Bounds bounds_of(const Scene& scene, const Instance& instance);
/// Of all instances; empty where there are none.
Bounds bounds_of(const Scene& scene);

}  // namespace etendue
