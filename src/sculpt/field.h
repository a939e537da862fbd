#pragma once
/// Solids as scalar fields: negative inside, zero on the surface, and outside approximately the distance to it. The
/// building blocks are exact or nearly exact distances, joined by smooth minima (Quílez 2013, "smooth minimum": the
/// quadratic form).

#include <algorithm>
#include <functional>

#include "sculpt/vec.h"

namespace etendue::sculpt {

/// A solid whose surface is strictly inside the box [lower, upper]. The values at two points differ by at most
/// `lipschitz` times the distance between the points.
struct Solid {
  std::function<double(Vec3)> value;
  Vec3 lower, upper;
  double lipschitz = 1.0;
};

inline double sphere(Vec3 p, Vec3 center, double radius) {
  return length(p - center) - radius;
}

/// Distance to an axis-aligned ellipsoid, exact to first order near the surface.
inline double ellipsoid(Vec3 p, Vec3 center, Vec3 radii) {
  const Vec3 q = (p - center) / radii;
  const double k0 = length(q), k1 = length(q / radii);
  if (k1 < 1e-9) return -std::min({radii.x, radii.y, radii.z});
  return k0 * (k0 - 1.0) / k1;
}

/// A capsule whose radius changes from `ra` at `a` to `rb` at `b`.
inline double capsule(Vec3 p, Vec3 a, Vec3 b, double ra, double rb) {
  const Vec3 ab = b - a;
  const double t = clamp01(dot(p - a, ab) / dot(ab, ab));
  return length(p - (a + t * ab)) - mix(ra, rb, t);
}

/// A ring around the y axis through `center`.
inline double torus(Vec3 p, Vec3 center, double radius, double tube) {
  const Vec3 q = p - center;
  const double r = std::sqrt(q.x * q.x + q.z * q.z) - radius;
  return std::sqrt(r * r + q.y * q.y) - tube;
}

/// A disc around the y axis whose edges are rounded with radius `round`.
inline double disc(Vec3 p, Vec3 center, double radius, double half_height, double round) {
  const Vec3 q = p - center;
  const double dx = std::sqrt(q.x * q.x + q.z * q.z) - (radius - round), dy = std::abs(q.y) - (half_height - round);
  const double ox = std::max(dx, 0.0), oy = std::max(dy, 0.0);
  return std::min(std::max(dx, dy), 0.0) + std::sqrt(ox * ox + oy * oy) - round;
}

/// Union, intersection and difference with a fillet of about size `k`.
inline double join(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0);
  return std::min(a, b) - h * h / (4.0 * k);
}
inline double intersect(double a, double b, double k) {
  return -join(-a, -b, k);
}
inline double carve(double a, double b, double k) {
  return intersect(a, -b, k);
}

/// Gradient noise with a wavelength of about 1, in [-1, 1] but mostly near 0. The fade is the quintic of [Perlin2002].
double noise(Vec3 p);

/// The built-in solids, about one unit high, y up, facing +z.
Solid bust();          ///< a head with curls on a pedestal that stands on y = 0
Solid bumpy_sphere();  ///< around the origin, radius about 0.5
Solid fir();           ///< the crown of a tree, from y = 0.1 up to its tip at y = 1.1

}  // namespace etendue::sculpt
