#include "reference/intersect.h"

#include <algorithm>
#include <cmath>

namespace etendue::reference {
namespace {

constexpr double kDegenerateShare = 1e-14;

/// a·d − b·c; its sign decides on which side of an edge the ray passes. An exact zero may be due to rounding, so it is
/// computed again with more digits if the platform has them.
double edge_function(double a, double b, double c, double d) {
  const double value = a * d - b * c;
  if (value != 0.0) return value;
  return static_cast<double>(static_cast<long double>(a) * d - static_cast<long double>(b) * c);
}

}  // namespace

double triangle_area(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
  return is_degenerate(p0, p1, p2) ? 0.0 : 0.5 * glm::length(glm::cross(p1 - p0, p2 - p0));
}

bool is_degenerate(const Vec3& p0, const Vec3& p1, const Vec3& p2) {
  const Vec3 e0 = p1 - p0, e1 = p2 - p1, e2 = p0 - p2;
  const double longest = std::max({glm::dot(e0, e0), glm::dot(e1, e1), glm::dot(e2, e2)});
  const double doubled_area = glm::length(glm::cross(e0, p2 - p0));
  return !(doubled_area > kDegenerateShare * longest);  // also for NaN
}

TriangleTest::TriangleTest(const Ray& ray) : origin_(ray.origin), t_min_(ray.t_min) {
  const Vec3 size = glm::abs(ray.direction);
  const int z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  int x = (z + 1) % 3;
  int y = (x + 1) % 3;
  if (ray.direction[z] < 0.0) std::swap(x, y);  // keeps the winding
  axis_ = {x, y, z};
  const double scale = 1.0 / ray.direction[z];
  shear_ = {ray.direction[x] * scale, ray.direction[y] * scale, scale};
}

std::optional<TriangleHit> TriangleTest::operator()(const Vec3& p0, const Vec3& p1, const Vec3& p2,
                                                    double t_max) const {
  const auto [x, y, z] = axis_;
  const auto sheared = [&, x = x, y = y, z = z](const Vec3& p) {
    const Vec3 v = p - origin_;
    return Vec3(v[x] - shear_.x * v[z], v[y] - shear_.y * v[z], shear_.z * v[z]);
  };
  const Vec3 a = sheared(p0), b = sheared(p1), c = sheared(p2);
  const double u = edge_function(c.x, c.y, b.x, b.y);
  const double v = edge_function(a.x, a.y, c.x, c.y);
  const double w = edge_function(b.x, b.y, a.x, a.y);
  if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return std::nullopt;
  const double determinant = u + v + w;
  if (determinant == 0.0) return std::nullopt;
  const Vec3 barycentric = Vec3(u, v, w) / determinant;
  const double t = glm::dot(barycentric, Vec3(a.z, b.z, c.z));
  if (!(t > t_min_ && t < t_max)) return std::nullopt;
  return TriangleHit{t, barycentric};
}

std::optional<double> intersect_sphere(const Ray& ray, const Vec3& center, double radius, double t_max) {
  const Vec3 from_center = ray.origin - center;
  const double b = glm::dot(from_center, ray.direction);
  const Vec3 across = from_center - b * ray.direction;  // from the centre to the nearest point of the line
  const double discriminant = radius * radius - glm::dot(across, across);
  if (discriminant < 0.0) return std::nullopt;
  // t² + 2bt + c = 0: take the root without cancellation, the other one from the product of the roots.
  const double distance = glm::length(from_center);
  const double c = (distance - radius) * (distance + radius);
  const double q = -b - std::copysign(std::sqrt(discriminant), b);
  double near = q, far = q != 0.0 ? c / q : 0.0;
  if (near > far) std::swap(near, far);
  if (near > ray.t_min && near < t_max) return near;
  if (far > ray.t_min && far < t_max) return far;
  return std::nullopt;
}

}  // namespace etendue::reference
