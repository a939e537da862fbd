#include "reference/shapes.h"

#include <algorithm>
#include <cmath>

namespace etendue::reference {

Vec3 Ellipse::normal() const {
  // Unit vectors first: the cross product of tiny half axes leaves the range of a double.
  return glm::normalize(glm::cross(glm::normalize(a), glm::normalize(b)));
}

double Ellipse::area() const {
  return kPi * glm::length(glm::cross(a, b));
}

glm::dvec2 Ellipse::coordinates(const Vec3& point) const {
  // Cramer's rule in the plane: from the center, point = x a + y b.
  const Vec3 from_center = point - center;
  const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b);
  const double pa = glm::dot(from_center, a), pb = glm::dot(from_center, b);
  return glm::dvec2(pa * bb - pb * ab, pb * aa - pa * ab) / (aa * bb - ab * ab);
}

double Tube::area() const {
  return 2.0 * kPi * radius * height;
}

Vec3 Tube::outward(const Vec3& point) const {
  const Vec3 from_base = point - base;
  return glm::normalize(from_base - glm::dot(from_base, axis) * axis);
}

double Tube::along(const Vec3& point) const {
  return std::clamp(glm::dot(point - base, axis), 0.0, height);
}

std::optional<double> intersect(const Ray& ray, const Ellipse& ellipse, double t_max) {
  const Vec3 n = ellipse.normal();
  const double cosine = glm::dot(n, ray.direction);
  if (cosine == 0.0) return std::nullopt;  // along the plane
  const double t = glm::dot(n, ellipse.center - ray.origin) / cosine;
  if (!(t > ray.t_min && t < t_max)) return std::nullopt;
  const glm::dvec2 xy = ellipse.coordinates(ray.origin + t * ray.direction);
  if (!(glm::dot(xy, xy) <= 1.0)) return std::nullopt;
  return t;
}

std::optional<double> intersect(const Ray& ray, const Tube& tube, double t_max) {
  // In the plane across the axis the tube is a circle, and the ray a line with direction d, whose length is not 1.
  const auto across = [&](const Vec3& v) { return v - glm::dot(v, tube.axis) * tube.axis; };
  const Vec3 from_base = ray.origin - tube.base;
  const Vec3 o = across(from_base), d = across(ray.direction);
  const double speed = glm::length(d);
  if (speed == 0.0) return std::nullopt;
  const Vec3 u = d / speed;
  const double middle = -glm::dot(o, u);  // distance in that plane to where the line comes nearest to the axis
  const Vec3 nearest = o + middle * u;
  const double discriminant = tube.radius * tube.radius - glm::dot(nearest, nearest);
  if (discriminant < 0.0) return std::nullopt;
  // The root that does not cancel, and the other one by the product of both.
  const double distance = glm::length(o);
  const double product = (distance - tube.radius) * (distance + tube.radius);
  const double outer = middle + std::copysign(std::sqrt(discriminant), middle);
  double first = outer != 0.0 ? product / outer : 0.0, second = outer;
  if (first > second) std::swap(first, second);
  for (const double s : {first, second}) {
    const double t = s / speed;
    const double z = glm::dot(from_base + t * ray.direction, tube.axis);
    if (t > ray.t_min && t < t_max && z >= 0.0 && z <= tube.height) return t;
  }
  return std::nullopt;
}

}  // namespace etendue::reference
