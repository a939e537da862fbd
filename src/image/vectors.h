#pragma once
/// Small functions for vectors and colours, shared by everything except the reference and the closed forms, which share
/// nothing with the code that they check.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

namespace etendue {

inline constexpr double kPi = std::numbers::pi;

/// Of linear Rec. 709.
inline double luminance(const glm::dvec3& rgb) {
  return glm::dot(rgb, glm::dvec3(0.212671, 0.715160, 0.072169));
}
inline bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_finite(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column) {
    if (!is_finite(glm::dvec3(m[column])) || !std::isfinite(m[column].w)) return false;
  }
  return true;
}
inline double largest_component(const glm::dvec3& v) {
  return std::max({v.x, v.y, v.z});
}
/// Whatever its sign.
inline double largest_coordinate(const glm::dvec3& v) {
  return largest_component(glm::abs(v));
}

}  // namespace etendue
