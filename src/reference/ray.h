#pragma once
/// Rays and what they hit.

#include <cstdint>
#include <limits>
#include <optional>

#include "reference/vec.h"

namespace etendue::reference {

struct Ray {
  Vec3 origin{0.0};
  Vec3 direction{0.0};  ///< unit length
  double t_min = 0.0;   ///< hits count in the open interval (t_min, t_max)
  double t_max = std::numeric_limits<double>::infinity();
  /// An instance whose surface at t_min the ray has passed: at t_min itself those behind it in the order of the scene
  /// count, too, and of itself only what lies beyond `t_own`.
  struct Passed {
    std::uint32_t instance;
    double t_own;
  };
  std::optional<Passed> passed = {};
};

/// A point of the scene's surface.
struct Surface {
  Vec3 p{0.0};
  Vec3 ng{0.0};            ///< geometric normal, unit
  Vec3 ns{0.0};            ///< shading normal, unit
  double magnitude = 0.0;  ///< largest coordinate of the primitive: what rounding errors are proportional to
  std::uint32_t instance = 0;
  std::uint32_t primitive = 0;
  Vec3 weights{0.0};  ///< of the triangle's vertices
  double t = 0.0;     ///< along the ray that met it

  static constexpr double kRelativeOffset = 0x1p-42;
  /// Where a ray toward `w` starts (or one from there ends): off the surface, to the side of `w`, by far more than the
  /// rounding error of `p` (a few 2^-53 of `magnitude`) and far less than anything visible. Coplanar neighbours that
  /// share an edge lie within that error, so they are left behind as well.
  Vec3 offset_toward(const Vec3& w) const {
    return p + ng * (glm::dot(w, ng) >= 0.0 ? kRelativeOffset * magnitude : -kRelativeOffset * magnitude);
  }
};

}  // namespace etendue::reference
