#pragma once
/// Orthonormal frame around a direction; +Z of the local frame is the direction.

#include <cmath>

#include "reference/vec.h"

namespace etendue::reference {

/// Right-handed basis (s, t, n) without branches on the direction. Source: [Duff2017], listing 3.
class Frame {
 public:
  explicit Frame(const Vec3& unit) : n_(unit) {
    const double sign = unit.z >= 0.0 ? 1.0 : -1.0;
    const double a = -1.0 / (sign + unit.z);
    const double b = unit.x * unit.y * a;
    s_ = {1.0 + sign * unit.x * unit.x * a, sign * b, -sign * unit.x};
    t_ = {b, sign + unit.y * unit.y * a, -unit.y};
  }
  /// The same, with s along the part of `u` perpendicular to the normal; any s if that part vanishes.
  Frame along(const Vec3& u) const {
    const Vec3 across = u - glm::dot(u, n_) * n_;
    if (!(glm::length(across) > 0.0)) return *this;
    Frame other = *this;
    other.s_ = glm::normalize(across);
    other.t_ = glm::cross(n_, other.s_);
    return other;
  }
  const Vec3& normal() const { return n_; }
  /// The same frame seen from the other side: left-handed if this one is right-handed.
  Frame mirrored() const {
    Frame other = *this;
    other.n_ = -n_;
    return other;
  }
  Vec3 to_world(const Vec3& local) const { return local.x * s_ + local.y * t_ + local.z * n_; }
  Vec3 to_local(const Vec3& world) const { return {glm::dot(world, s_), glm::dot(world, t_), glm::dot(world, n_)}; }

 private:
  Vec3 s_, t_, n_;
};

}  // namespace etendue::reference
