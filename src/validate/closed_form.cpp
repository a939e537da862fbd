#include "validate/closed_form.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace etendue::closed_form {
namespace {

/// Sutherland–Hodgman against the plane v·n = 0.
std::vector<glm::dvec3> above_horizon(std::span<const glm::dvec3> polygon, const glm::dvec3& n) {
  std::vector<glm::dvec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3& a = polygon[i];
    const glm::dvec3& b = polygon[(i + 1) % polygon.size()];
    const double ha = glm::dot(a, n), hb = glm::dot(b, n);
    if (ha >= 0.0) kept.push_back(a);
    if ((ha >= 0.0) != (hb >= 0.0)) kept.push_back(glm::mix(a, b, ha / (ha - hb)));
  }
  return kept;
}

double filter_value(const ReconstructionFilter& f, double x) {
  using Type = ReconstructionFilter::Type;
  const double size = std::abs(x);
  switch (f.type) {
    case Type::box:
      return size <= 0.5 * f.stretch ? 1.0 : 0.0;
    case Type::tent:
      return std::max(0.0, f.stretch - size);
    case Type::gaussian: {
      const double s = 2.0 * f.stddev * f.stddev;
      return std::max(0.0, std::exp(-x * x / s) - std::exp(-f.radius * f.radius / s));
    }
    case Type::lanczos: {
      const double t = std::numbers::pi * size, n = f.lobes;
      return size >= n ? 0.0 : size == 0.0 ? 1.0 : n * std::sin(t) * std::sin(t / n) / (t * t);
    }
    case Type::mitchell:
      break;
  }
  const double t = 2.0 * size / f.radius, b = f.b, c = f.c;  // the cubic has support 2
  if (t >= 2.0) return 0.0;
  if (t >= 1.0)
    return ((-b - 6 * c) * t * t * t + (6 * b + 30 * c) * t * t + (-12 * b - 48 * c) * t + (8 * b + 24 * c)) / 6.0;
  return ((12 - 9 * b - 6 * c) * t * t * t + (-18 + 12 * b + 6 * c) * t * t + (6 - 2 * b)) / 6.0;
}

double filter_support(const ReconstructionFilter& f) {
  using Type = ReconstructionFilter::Type;
  if (f.type == Type::box) return 0.5 * f.stretch;
  if (f.type == Type::tent) return f.stretch;
  return f.type == Type::lanczos ? f.lobes : f.radius;
}

/// Midpoint rule: exact enough for the kinks the filters have, 1e-7 of the whole.
double integrate_filter(const ReconstructionFilter& f, double from, double to) {
  constexpr int kSteps = 4000;
  const double step = (to - from) / kSteps;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += filter_value(f, from + (i + 0.5) * step);
  return sum * step;
}

}  // namespace

double polygon_irradiance(std::span<const glm::dvec3> vertices, const glm::dvec3& n) {
  const std::vector<glm::dvec3> polygon = above_horizon(vertices, n);
  double sum = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 a = glm::normalize(polygon[i]);
    const glm::dvec3 b = glm::normalize(polygon[(i + 1) % polygon.size()]);
    const glm::dvec3 edge = glm::cross(a, b);
    const double sine = glm::length(edge);
    if (sine > 0.0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(edge / sine, n);
  }
  // Seen from its emitting side the polygon runs counter-clockwise, that is negatively about the direction toward it.
  return std::max(0.0, -0.5 * sum);
}

double sphere_irradiance(const glm::dvec3& center, double radius, const glm::dvec3& n) {
  const double h = glm::length(center) / radius;
  const double cosine = glm::dot(glm::normalize(center), n);
  if (h * cosine >= 1.0) return std::numbers::pi * cosine / (h * h);
  if (h * cosine <= -1.0) return 0.0;
  const double sine = std::sqrt(1.0 - cosine * cosine), tangent = std::sqrt(h * h - 1.0);
  const double lune = std::acos(std::clamp(-tangent * cosine / sine, -1.0, 1.0));
  const double cut = std::sqrt(1.0 - h * h * cosine * cosine);
  return (cosine * lune - tangent * cut) / (h * h) + std::atan(cut / tangent);
}

double clamped_cosine_product(const glm::dvec3& a, const glm::dvec3& b) {
  const double cosine = std::clamp(glm::dot(a, b), -1.0, 1.0);
  const double angle = std::acos(cosine);
  return 2.0 / 3.0 * (std::sin(angle) + (std::numbers::pi - angle) * cosine);
}

double fresnel_reflectance(double cos_o, double n_o, double n_t) {
  const double sin_t = n_o / n_t * std::sqrt(std::max(0.0, 1.0 - cos_o * cos_o));
  if (sin_t >= 1.0) return 1.0;
  const double cos_t = std::sqrt(1.0 - sin_t * sin_t);
  const double s = (n_o * cos_o - n_t * cos_t) / (n_o * cos_o + n_t * cos_t);
  const double p = (n_t * cos_o - n_o * cos_t) / (n_t * cos_o + n_o * cos_t);
  return 0.5 * (s * s + p * p);
}

double fresnel_reflectance_of_metal(double cos_o, double eta, double k) {
  const double sin2 = std::max(0.0, 1.0 - cos_o * cos_o), difference = eta * eta - k * k - sin2;
  const double modulus = std::hypot(difference, 2.0 * eta * k);  // u² + v² of Born and Wolf's §14.2
  const double u = std::sqrt(std::max(0.0, 0.5 * (modulus + difference)));
  const double s = (modulus - 2.0 * u * cos_o + cos_o * cos_o) / (modulus + 2.0 * u * cos_o + cos_o * cos_o);
  if (cos_o == 0.0) return 1.0;
  const double tangential = sin2 / cos_o;
  const double p = s * (modulus - 2.0 * u * tangential + tangential * tangential) /
                   (modulus + 2.0 * u * tangential + tangential * tangential);
  return 0.5 * (s + p);
}

double filter_share(const ReconstructionFilter& filter, double x) {
  const double support = filter_support(filter);
  return integrate_filter(filter, -support, std::clamp(x, -support, support)) /
         integrate_filter(filter, -support, support);
}

}  // namespace etendue::closed_form
