#include "reference/microfacet_distribution.h"

#include <algorithm>
#include <cmath>

namespace etendue::reference {
namespace {

using Distribution = Roughness::Distribution;

/// erf⁻¹(x) for |x| < 1, by bisection on the side where the complement keeps its digits.
double inverse_erf(double x) {
  const double complement = 1.0 - std::abs(x);
  double low = 0.0, high = 7.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (std::erfc(middle) > complement ? low : high) = middle;
  }
  return std::copysign(0.5 * (low + high), x);
}

/// ∫ (cos − sin · x) exp(−x²) dx from −∞ to x <= cot θ, times 1/√π: area that microfacets of Beckmann's distribution
/// (α = 1) with slopes up to x show to a direction at θ.
double beckmann_visible_area(double cos_theta, double sin_theta, double x) {
  return 0.5 * cos_theta * std::erfc(-x) + sin_theta * std::exp(-x * x) / (2.0 * std::sqrt(kPi));
}

/// The slope x up to which the share u of that area lies.
double beckmann_visible_slope(double cos_theta, double sin_theta, double u) {
  const double end = sin_theta > 0.0 ? std::min(cos_theta / sin_theta, 9.0) : 9.0;
  const double wanted = u * beckmann_visible_area(cos_theta, sin_theta, end);
  double low = -9.0, high = end;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (beckmann_visible_area(cos_theta, sin_theta, middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// A normal of α = 1 that `w` sees [Heitz2014, supplemental material]: slopes along and across w's azimuth are
/// independent.
Vec3 sample_visible_beckmann(const Vec3& w, const Vec2& u) {
  const double sin_theta = std::hypot(w.x, w.y);
  const double along = beckmann_visible_slope(w.z, sin_theta, u.x + 0x1p-25);
  const double across = inverse_erf(2.0 * u.y - 1.0 + 0x1p-24);
  const Vec2 azimuth = sin_theta > 0.0 ? Vec2(w.x, w.y) / sin_theta : Vec2(1.0, 0.0);
  return {-along * azimuth.x + across * azimuth.y, -along * azimuth.y - across * azimuth.x, 1.0};
}

/// The same of GGX: the hemisphere seen from `w` reflects parallel rays evenly into a spherical cap [Dupuy2023].
Vec3 sample_visible_ggx(const Vec3& w, const Vec2& u) {
  const double z = (1.0 - u.x) * (1.0 + w.z) - w.z, phi = 2.0 * kPi * u.y;
  const double sin_theta = std::sqrt(std::max(0.0, 1.0 - z * z));
  return Vec3(sin_theta * std::cos(phi), sin_theta * std::sin(phi), z) + w;
}

}  // namespace

double MicrofacetDistribution::density(const Vec3& h) const {
  if (h.z <= 0.0) return 0.0;
  const double x = h.x / (r_.alpha_u.value * h.z), y = h.y / (r_.alpha_v.value * h.z);
  const double tan2 = x * x + y * y;  // of the stretched normal
  const double area = kPi * r_.alpha_u.value * r_.alpha_v.value * std::pow(h.z, 4);
  if (r_.distribution == Distribution::beckmann) return tan2 <= 50.0 ? std::exp(-tan2) / area : 0.0;
  return 1.0 / (area * (1.0 + tan2) * (1.0 + tan2));
}

double MicrofacetDistribution::masking(const Vec3& w, const Vec3& h) const {
  if (glm::dot(w, h) * w.z <= 0.0) return 0.0;
  const double tan_theta = std::hypot(r_.alpha_u.value * w.x, r_.alpha_v.value * w.y) / std::abs(w.z);
  if (r_.distribution == Distribution::ggx) return 2.0 / (1.0 + std::sqrt(1.0 + tan_theta * tan_theta));
  const double a = 1.0 / tan_theta;
  if (a >= 1.6) return 1.0;
  return (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a);
}

double MicrofacetDistribution::visible_area(const Vec3& w) const {
  const double sin_theta =
      std::hypot(r_.alpha_u.value * w.x, r_.alpha_v.value * w.y);  // both scaled alike: only w.z is not
  if (r_.distribution == Distribution::ggx) return 0.5 * (w.z + std::sqrt(w.z * w.z + sin_theta * sin_theta));
  return beckmann_visible_area(w.z, sin_theta, sin_theta > 0.0 ? w.z / sin_theta : INFINITY);
}

double MicrofacetDistribution::visible_density(const Vec3& w, const Vec3& h) const {
  const double cos_h = glm::dot(w, h);
  return cos_h > 0.0 ? density(h) * cos_h / visible_area(w) : 0.0;
}

Vec3 MicrofacetDistribution::sample_visible(const Vec3& w, const Vec2& u) const {
  const Vec3 flat = stretched(w);
  const Vec3 h = r_.distribution == Distribution::ggx ? sample_visible_ggx(flat, u) : sample_visible_beckmann(flat, u);
  return glm::normalize(Vec3(r_.alpha_u.value * h.x, r_.alpha_v.value * h.y, h.z));
}

}  // namespace etendue::reference
