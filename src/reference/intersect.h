#pragma once
/// Rays against one primitive, in double precision.

#include <array>
#include <optional>

#include "reference/ray.h"

namespace etendue::reference {

/// Twice the triangle's area is no larger than this share of its longest edge squared: all digits of its normal are
/// rounding errors. Such a triangle is degenerate: never hit, never chosen as a light.
bool is_degenerate(const Vec3& p0, const Vec3& p1, const Vec3& p2);
/// 0 for a degenerate triangle.
double triangle_area(const Vec3& p0, const Vec3& p1, const Vec3& p2);

struct TriangleHit {
  double t = 0.0;
  Vec3 barycentric{0.0};  ///< weights of p0, p1, p2
};

/// Watertight test: no ray slips through an edge shared by two triangles. Source: [Woop2013].
class TriangleTest {
 public:
  explicit TriangleTest(const Ray& ray);
  std::optional<TriangleHit> operator()(const Vec3& p0, const Vec3& p1, const Vec3& p2, double t_max) const;

 private:
  Vec3 origin_;
  double t_min_;
  std::array<int, 3> axis_;  ///< permutation that makes the direction's largest component the last
  Vec3 shear_;               ///< shear and scale that make the direction (0, 0, 1)
};

/// Smallest t in (ray.t_min, t_max) where the ray meets the sphere. The discriminant comes from the distance between
/// centre and line, so that precision is preserved for small and distant spheres. Source: [Haines2019].
std::optional<double> intersect_sphere(const Ray& ray, const Vec3& center, double radius, double t_max);

}  // namespace etendue::reference
