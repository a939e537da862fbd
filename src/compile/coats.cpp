#include "compile/coats.h"

#include <algorithm>
#include <array>
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
  bool is_beckmann() const { return beckmann_; }

 private:
  bool beckmann_;
  double alpha_;
};

/// Nodes and weights of the 8-point Gauss–Legendre rule on [0, 1].
struct Node {
  double at, weight;
};
constexpr Node kGauss[] = {{0.019855071751231856, 0.05061426814518813}, {0.10166676129318664, 0.11119051722668724},
                           {0.2372337950418355, 0.15685332293894364},   {0.4082826787521751, 0.18134189168918100},
                           {0.5917173212478249, 0.18134189168918100},   {0.7627662049581645, 0.15685332293894364},
                           {0.8983332387068134, 0.11119051722668724},   {0.9801449282487681, 0.05061426814518813}};

/// ∫ f over [a, b], where f may have a root's singularity at either end: both halves are integrated in the root of the
/// distance from their end.
template <typename F>
double integrate_between_kinks(double a, double b, F&& f) {
  const double half = 0.5 * (b - a);
  double sum = 0.0;
  for (const Node& node : kGauss) {
    const double distance = half * node.at * node.at;
    sum += node.weight * 2.0 * node.at * half * (f(a + distance) + f(b - distance));
  }
  return sum;
}

/// The microfacets whose normals have the slope ρ α, all around: their cosines with the light w are
/// `scale · (cosine + spread cos φ)`, with φ from the azimuth of w.
struct Ring {
  double cosine, spread, scale;
  double facet_cosine(double phi) const { return std::min(1.0, scale * (cosine + spread * std::cos(phi))); }
  /// Where that cosine falls to `value`, in [0, π].
  double azimuth(double value) const {
    return spread > 0.0 ? std::acos(std::clamp((value / scale - cosine) / spread, -1.0, 1.0))
                        : (value < scale * cosine ? kPi : 0.0);
  }
};

/// ∫ f(ring) over the slopes, weighted by their distribution and relative to the area that w sees, in the logarithm of
/// ρ: there both the lobe and the tail of GGX at ρ = 1/α are wide. `kinks` are angles of normals where f is not smooth.
template <typename F>
double over_rings(const Facets& facets, double cosine, std::array<double, 4> kinks, F&& f) {
  constexpr double kFirst = -9.0, kPanel = 1.5;  // width of a panel, which has 16 nodes
  const double last = facets.is_beckmann() ? 2.0 : 16.0;
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  const auto weighted = [&](double x) {
    const double slope = std::exp(x), spread = sine * facets.alpha() * slope;
    const Ring ring{cosine, spread, 1.0 / std::sqrt(1.0 + facets.alpha() * facets.alpha() * slope * slope)};
    return facets.slope_density(slope) * slope * slope * f(ring);
  };
  std::ranges::sort(kinks);
  double sum = 0.0, from = kFirst;
  for (std::size_t i = 0; i <= kinks.size(); ++i) {
    const bool at_kink = i < kinks.size() && kinks[i] > 0.0 && kinks[i] < 0.5 * kPi;
    const double to = at_kink ? std::clamp(std::log(std::tan(kinks[i]) / facets.alpha()), kFirst, last) : last;
    if (!at_kink && i < kinks.size()) continue;
    const int panels = static_cast<int>(std::ceil((to - from) / kPanel));
    for (int k = 0; k < panels; ++k)
      sum += integrate_between_kinks(from + (to - from) * k / panels, from + (to - from) * (k + 1) / panels, weighted);
    from = to;
  }
  return 2.0 * sum / facets.visible_area(cosine);
}

/// The fraction of light from a direction of this cosine that the microfacets transmit, with eta = n_t / n_o > 1; light
/// that meets a second microfacet does not count.
double passed_share(const Facets& facets, double cosine, double eta) {
  const double hidden = 0.5 * kPi - std::acos(cosine);  // normals that tilt further may face away from w
  return over_rings(facets, cosine, {hidden}, [&](const Ring& ring) {
    return integrate_between_kinks(0.0, ring.azimuth(0.0), [&](double phi) {
      const double w_h = ring.facet_cosine(phi), bent = std::sqrt(1.0 - (1.0 - w_h * w_h) / (eta * eta));
      const double z = (w_h / eta - bent) * ring.scale - cosine / eta;
      return z < 0.0 ? w_h / ring.scale * (1.0 - fresnel(w_h, eta)) * facets.masking(-z) : 0.0;
    });
  });
}

/// The fraction that they reflect, with eta < 1.
double reflected_share(const Facets& facets, double cosine, double eta) {
  const double critical = std::sqrt(1.0 - eta * eta), angle = std::acos(cosine), limit = std::acos(critical);
  // Where reflection is total, or goes down, at the azimuth of w or opposite to it.
  const std::array kinks{std::abs(angle - limit), angle + limit, 0.5 * (0.5 * kPi - angle), 0.5 * (0.5 * kPi + angle)};
  return over_rings(facets, cosine, kinks, [&](const Ring& ring) {
    const auto light = [&](double phi) {
      const double w_h = ring.facet_cosine(phi), z = 2.0 * w_h * ring.scale - cosine;
      return z > 0.0 && w_h > 0.0 ? w_h / ring.scale * fresnel(w_h, eta) * facets.masking(z) : 0.0;
    };
    const double end = ring.azimuth(cosine / (2.0 * ring.scale));  // beyond it, light goes down
    const double total = std::min(end, ring.azimuth(critical));    // beyond it, some is transmitted
    return integrate_between_kinks(0.0, total, light) + integrate_between_kinks(total, end, light);
  });
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
    coat.transmittances[i] = static_cast<float>(passed_share(facets, cosine, eta));
    coat.reflectance_inside += 2.0 * cosine * reflected_share(facets, cosine, 1.0 / eta) / gpu::kTransmittanceNodes;
  }
  return coat;
}

}  // namespace etendue
