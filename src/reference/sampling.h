#pragma once
/// Warps: maps from the unit square to the shapes light is sampled on; docs/conventions.md, "Warps".

#include <algorithm>
#include <cmath>

#include "reference/vec.h"

namespace etendue::reference {

/// Uniform on the unit disk; `pdf_a` = 1/π. Source: [Shirley1997].
inline Vec2 square_to_disk(const Vec2& u) {
  // The middle of the cell that the random number stands for; never the rim, never the centre.
  const double a = 2.0 * u.x - 1.0 + 0x1p-24;
  const double b = 2.0 * u.y - 1.0 + 0x1p-24;
  double r, phi;
  if (std::abs(a) > std::abs(b)) {
    r = a;
    phi = kPi / 4.0 * (b / a);
  } else {
    r = b;
    phi = kPi / 2.0 - kPi / 4.0 * (a / b);
  }
  return {r * std::cos(phi), r * std::sin(phi)};
}

/// Cosine-distributed unit direction with z > 0; `pdf_w` = z/π.
inline Vec3 square_to_cosine_hemisphere(const Vec2& u) {
  const Vec2 disk = square_to_disk(u);
  return {disk.x, disk.y, std::sqrt(std::max(0.0, 1.0 - glm::dot(disk, disk)))};
}

/// Barycentric weights of a point uniform on a triangle. Source: [Turk1990].
inline Vec3 square_to_triangle(const Vec2& u) {
  const double root = std::sqrt(u.x);
  const double b0 = 1.0 - root;
  const double b1 = u.y * root;
  return {b0, b1, 1.0 - b0 - b1};
}

/// The inverse: the numbers that lead to these weights.
inline Vec2 triangle_to_square(const Vec3& weights) {
  const double root = 1.0 - weights.x;
  return {root * root, root > 0.0 ? weights.y / root : 0.0};
}

/// The cone a sphere fills, seen from outside. Source: [Shirley1996].
struct SphereCone {
  double one_minus_cos_max = 0.0;  ///< 1 − cos θ_max, in a form that keeps its digits for tiny spheres

  SphereCone(double radius, double distance) {
    const double sin_max = radius / distance;
    const double sin2 = sin_max * sin_max;
    one_minus_cos_max = sin2 / (1.0 + std::sqrt(std::max(0.0, 1.0 - sin2)));
  }
  /// Density w.r.t. solid angle, constant inside the cone.
  double pdf_w() const { return 1.0 / (2.0 * kPi * one_minus_cos_max); }
  /// Unit direction around +Z, uniform in the cone.
  Vec3 sample(const Vec2& u) const {
    const double x = u.x * one_minus_cos_max;  // 1 − cos θ
    const double sin_theta = std::sqrt(std::max(0.0, x * (2.0 - x)));
    const double phi = 2.0 * kPi * u.y;
    return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), 1.0 - x};
  }
};

}  // namespace etendue::reference
