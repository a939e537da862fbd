#pragma once
/// Disks and cylinders in the world, and rays against them, in double precision.

#include <optional>

#include "reference/ray.h"
#include "scene/scene.h"

namespace etendue::reference {

/// The points center + x·a + y·b with x² + y² <= 1: what an affine map makes of the unit disk. Its normal is a × b.
struct Ellipse {
  Vec3 center{0.0}, a{0.0}, b{0.0};

  Vec3 normal() const;
  double area() const;
  /// (x, y) of a point of its plane.
  glm::dvec2 coordinates(const Vec3& point) const;
};

/// The side of a cylinder without its ends.
struct Tube {
  Vec3 base{0.0};
  Vec3 axis{0.0};  ///< unit
  double height = 0.0;
  double radius = 0.0;
  double side = 1.0;  ///< −1 where the normal points toward the axis

  double area() const;
  Vec3 outward(const Vec3& point) const;
  /// Where a point of the surface lies along the axis.
  double along(const Vec3& point) const;
};

/// t in (ray.t_min, t_max) where the ray crosses the ellipse.
std::optional<double> intersect(const Ray& ray, const Ellipse& ellipse, double t_max);
/// The smallest t in (ray.t_min, t_max) where the ray meets the tube.
std::optional<double> intersect(const Ray& ray, const Tube& tube, double t_max);

}  // namespace etendue::reference
