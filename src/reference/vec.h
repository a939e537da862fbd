#pragma once
/// Vocabulary of the reference renderer: double-precision vectors and constants.

#include <cmath>
#include <numbers>

#include <glm/glm.hpp>

namespace etendue::reference {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;

inline constexpr double kPi = std::numbers::pi;

/// Rec. 709 luminance with the weights of docs/conventions.md.
inline double luminance(const Vec3& rgb) {
  return 0.212671 * rgb.x + 0.715160 * rgb.y + 0.072169 * rgb.z;
}
inline double max_component(const Vec3& v) {
  return glm::max(v.x, glm::max(v.y, v.z));
}
/// Of whatever sign.
inline double largest_coordinate(const Vec3& v) {
  return max_component(glm::abs(v));
}
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_zero(const Vec3& v) {
  return v.x == 0.0 && v.y == 0.0 && v.z == 0.0;
}

}  // namespace etendue::reference
