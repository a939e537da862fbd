#include "compile/coats.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "image/vectors.h"

namespace etendue {
namespace {

double fresnel(double cosine, double eta) {
  const double sin2 = (1.0 - cosine * cosine) / (eta * eta);
  if (sin2 >= 1.0) return 1.0;
  const double bent = std::sqrt(1.0 - sin2);
  const double s = (cosine - eta * bent) / (cosine + eta * bent), p = (eta * cosine - bent) / (eta * cosine + bent);
  return 0.5 * (s * s + p * p);
}

/// Isotropic microfacets of roughness α, for light in the plane y = 0.
class Facets {
 public:
  explicit Facets(const Roughness& roughness)
      : beckmann_(roughness.distribution == Roughness::Distribution::beckmann), alpha_(roughness.alpha_u.value) {}

  /// D h.z³ α² as a function of the slope in units of α: the distribution of slopes.
  double slope_density(double slope) const {
    const double s2 = slope * slope;
    return beckmann_ ? std::exp(-s2) / kPi : 1.0 / (kPi * (1.0 + s2) * (1.0 + s2));
  }
  double masking(double cosine) const {
    const double tangent = std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine * alpha_;
    if (!beckmann_) return 2.0 / (1.0 + std::sqrt(1.0 + tangent * tangent));
    const double a = 1.0 / tangent;
    return a < 1.6 ? (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a) : 1.0;
  }
  /// ∫ D(h) max(0, w·h) dh.
  double visible_area(double cosine) const {
    const double s = alpha_ * std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    if (!beckmann_) return 0.5 * (cosine + std::sqrt(cosine * cosine + s * s));
    if (s == 0.0) return cosine;
    const double a = cosine / s;
    return 0.5 * cosine * std::erfc(-a) + s * std::exp(-a * a) / (2.0 * std::sqrt(kPi));
  }
  double alpha() const { return alpha_; }

 private:
  bool beckmann_;
  double alpha_;
};

struct Shares {
  double reflected = 0.0, passed = 0.0;
};

/// The fractions of light from a direction of this cosine that the microfacets reflect and transmit, with eta = n_t /
/// n_o; light that meets a second microfacet counts in neither. Midpoint rule over the slopes (q = ρ/(1 + ρ)) and half
/// a turn, which suffices by symmetry.
Shares shares(const Facets& facets, double cosine, double eta) {
  constexpr int kRings = 200, kSectors = 64;
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  Shares sum;
  for (int i = 0; i < kRings; ++i) {
    const double q = (i + 0.5) / kRings, slope = q / (1.0 - q), ring = slope / ((1.0 - q) * (1.0 - q));
    const double scale = 1.0 / std::sqrt(1.0 + facets.alpha() * facets.alpha() * slope * slope);  // h.z
    const double density = facets.slope_density(slope) * ring;
    for (int j = 0; j < kSectors; ++j) {
      const double x = facets.alpha() * slope * std::cos(kPi * (j + 0.5) / kSectors);
      const double across = cosine + sine * x;  // w·h / h.z
      if (across <= 0.0) continue;
      const double w_h = std::min(1.0, across * scale), f = fresnel(w_h, eta), weight = density * across;
      const double reflected_z = 2.0 * w_h * scale - cosine;
      if (reflected_z > 0.0) sum.reflected += weight * f * facets.masking(reflected_z);
      if (f >= 1.0) continue;
      const double bent = std::sqrt(1.0 - (1.0 - w_h * w_h) / (eta * eta));
      const double passed_z = (w_h / eta - bent) * scale - cosine / eta;
      if (passed_z < 0.0) sum.passed += weight * (1.0 - f) * facets.masking(-passed_z);
    }
  }
  const double norm = 2.0 * kPi / (kRings * kSectors) / facets.visible_area(cosine);
  return {sum.reflected * norm, sum.passed * norm};
}

/// Masking of the microfibres of sheen [Estevez2017].
double sheen_lambda(double cosine, double alpha) {
  const double t = (1.0 - alpha) * (1.0 - alpha);
  const auto blend = [t](double rough, double smooth) { return rough + t * (smooth - rough); };
  const double a = blend(21.5473, 25.3245), b = blend(3.82987, 3.32435), c = blend(0.19823, 0.16801),
               d = blend(-1.97760, -1.27393), e = blend(-4.32054, -4.85967);
  const auto curve = [&](double x) { return a / (1.0 + b * std::pow(x, c)) + d * x + e; };
  return std::exp(cosine < 0.5 ? curve(cosine) : 2.0 * curve(0.5) - curve(1.0 - cosine));
}

/// Midpoint rule over the hemisphere, evenly spaced in the roots of the cosines, because the lobe is at the horizon.
double sheen_albedo(double cosine, double alpha) {
  constexpr int kRings = 128, kSectors = 96;
  const double sine = std::sqrt(1.0 - cosine * cosine), masked = 1.0 + sheen_lambda(cosine, alpha);
  double sum = 0.0;
  for (int i = 0; i < kRings; ++i) {
    const double root = (i + 0.5) / kRings, z = root * root, s = std::sqrt(1.0 - z * z);
    const double visible = 2.0 * root / ((masked + sheen_lambda(z, alpha)) * 4.0 * cosine);
    for (int j = 0; j < kSectors; ++j) {
      const double phi = kPi * (j + 0.5) / kSectors, x = s * std::cos(phi) + sine, y = s * std::sin(phi);
      const double across = x * x + y * y, along = cosine + z;
      sum += visible * std::pow(across / (across + along * along), 0.5 / alpha);
    }
  }
  return sum * (2.0 + 1.0 / alpha) / (kRings * kSectors);
}

}  // namespace

double diffuse_reflectance_inside(double eta) {
  const double inverse = 1.0 / eta;  // the index seen from inside [dEon2011]
  return -1.4399 * inverse * inverse + 0.7099 * inverse + 0.6681 + 0.0636 * eta;
}

std::vector<float> sheen_albedos() {
  std::vector<float> table;
  for (gpu::uint row = 0; row < gpu::kSheenRoughnesses; ++row) {
    const double roughness = 0.1 + 0.9 * row / (gpu::kSheenRoughnesses - 1);
    for (gpu::uint i = 0; i < gpu::kSheenCosines; ++i) {
      const double cosine = std::max(1e-3, static_cast<double>(i) / (gpu::kSheenCosines - 1));
      // Slightly more than the true value, so that interpolated values are never below it.
      table.push_back(static_cast<float>(1.02 * sheen_albedo(cosine, roughness * roughness) + 0.002));
    }
  }
  return table;
}

RoughCoat rough_coat(const Roughness& roughness, double eta) {
  const Facets facets(roughness);
  RoughCoat coat;
  for (gpu::uint i = 0; i < gpu::kTransmittanceNodes; ++i) {
    const double cosine = std::max(1e-6, static_cast<double>(i) / (gpu::kTransmittanceNodes - 1));
    coat.transmittances[i] = static_cast<float>(shares(facets, cosine, eta).passed);
    coat.reflectance_inside += 2.0 * cosine * shares(facets, cosine, 1.0 / eta).reflected / gpu::kTransmittanceNodes;
  }
  return coat;
}

}  // namespace etendue
