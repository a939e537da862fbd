#pragma once
/// Axis-aligned boxes, single precision.

#include <algorithm>
#include <limits>

#include <glm/glm.hpp>

namespace etendue {

struct Box {
  glm::vec3 lower{std::numeric_limits<float>::infinity()};
  glm::vec3 upper{-std::numeric_limits<float>::infinity()};

  void extend(const glm::vec3& p) {
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
  }
  void extend(const Box& other) {
    lower = glm::min(lower, other.lower);
    upper = glm::max(upper, other.upper);
  }
  glm::vec3 center() const { return 0.5f * (lower + upper); }
  /// Half the surface area; 0 for an empty box.
  float half_area() const {
    const glm::vec3 d = glm::max(upper - lower, glm::vec3(0.0f));
    return d.x * d.y + d.y * d.z + d.z * d.x;
  }
};

}  // namespace etendue
