#include "reference/coat.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>

#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"
#include "scene/limits.h"

namespace etendue::reference {
namespace {

enum class Way { reflected, passed };

/// ∫ f over [a, b] by Simpson's rule, whose steps are halved until two of them agree with one to `tolerance`.
template <typename F>
double adaptive(F&& f, double a, double b, double fa, double fm, double fb, double tolerance, int halvings) {
  const double m = 0.5 * (a + b), left = f(0.5 * (a + m)), right = f(0.5 * (m + b));
  const double whole = (b - a) / 6.0 * (fa + 4.0 * fm + fb);
  const double both = (b - a) / 12.0 * (fa + 4.0 * left + 2.0 * fm + 4.0 * right + fb);
  if (halvings == 0 || std::abs(both - whole) <= 15.0 * tolerance) return both + (both - whole) / 15.0;
  return adaptive(f, a, m, fa, left, fm, 0.5 * tolerance, halvings - 1) +
         adaptive(f, m, b, fm, right, fb, 0.5 * tolerance, halvings - 1);
}
template <typename F>
double integrate(F&& f, double a, double b, int panels, double tolerance) {
  constexpr int kHalvings = 12;
  double sum = 0.0;
  for (int i = 0; i < panels; ++i) {
    const double from = a + (b - a) * i / panels, to = a + (b - a) * (i + 1) / panels;
    sum += adaptive(f, from, to, f(from), f(0.5 * (from + to)), f(to), tolerance / panels, kHalvings);
  }
  return sum;
}

/// Fraction of light from a direction of this cosine that the microfacets reflect, ∫ F G1(wi) over the visible normals,
/// or transmit, ∫ (1 − F) G1(wt): over half a turn, and over the angle atan ρ, with ρ the slope of the normal in units
/// of the roughness.
double share(const Roughness& roughness, double cosine, double n_o, double n_t, Way way) {
  const MicrofacetDistribution facets(roughness);
  const Vec3 w(std::sqrt(std::max(0.0, 1.0 - cosine * cosine)), 0.0, cosine);
  const auto leaves = [&](const Vec3& h) {
    const double w_h = glm::dot(w, h);
    if (w_h <= 0.0) return 0.0;
    const Fresnel fresnel = fresnel_dielectric(std::min(w_h, 1.0), n_o, n_t);
    if (way == Way::reflected) {
      const Vec3 wi = 2.0 * w_h * h - w;
      return wi.z > 0.0 ? fresnel.reflectance * facets.masking(wi, h) : 0.0;
    }
    const Vec3 wt = (n_o / n_t * w_h - fresnel.cos_transmitted) * h - n_o / n_t * w;
    return wt.z < 0.0 ? (1.0 - fresnel.reflectance) * facets.masking(wt, h) : 0.0;
  };
  const auto ring = [&](double angle) {
    const double slope = roughness.alpha_u.value * std::tan(angle);
    // dω of the normals: h.z³ · slope · d(slope) dφ.
    const double z = 1.0 / std::hypot(1.0, slope);
    const double area = z * z * z * slope * roughness.alpha_u.value / (std::cos(angle) * std::cos(angle));
    const auto at = [&](double phi) {
      const Vec3 h = z * Vec3(slope * std::cos(phi), slope * std::sin(phi), 1.0);
      return area * facets.visible_density(w, h) * leaves(h);
    };
    return integrate(at, 0.0, kPi, 4, 2e-7);
  };
  constexpr double kAlmostFlat = 1e-7;  // there the tangent is no longer finite
  return 2.0 * integrate(ring, 0.0, 0.5 * kPi - kAlmostFlat, 24, 1e-6);
}

/// The coat of a material, computed once per process for each set of parameters.
const RoughCoat& rough_coat(const Roughness& roughness, double int_ior, double ext_ior) {
  using Key = std::tuple<Roughness::Distribution, double, double, double>;
  static std::mutex mutex;
  static std::map<Key, std::unique_ptr<RoughCoat>> coats;
  thread_local std::map<Key, const RoughCoat*> own;  // found without locking
  const RoughCoat*& known = own[Key(roughness.distribution, roughness.alpha_u.value, int_ior, ext_ior)];
  if (known != nullptr) return *known;
  const std::lock_guard lock(mutex);
  std::unique_ptr<RoughCoat>& coat = coats[Key(roughness.distribution, roughness.alpha_u.value, int_ior, ext_ior)];
  if (!coat) coat = std::make_unique<RoughCoat>(roughness, int_ior, ext_ior);
  known = coat.get();
  return *known;
}

}  // namespace

double diffuse_reflectance_inside(double int_ior, double ext_ior) {
  const double eta = ext_ior / int_ior;
  return 0.0636 / eta + 0.6681 + 0.7099 * eta - 1.4399 * eta * eta;
}

RoughCoat::RoughCoat(const Roughness& roughness, double int_ior, double ext_ior) {
  for (std::size_t i = 0; i < kNodes; ++i) {
    const double cosine = std::max(1e-6, static_cast<double>(i) / (kNodes - 1));
    nodes_[i] = share(roughness, cosine, ext_ior, int_ior, Way::passed);
    inside_ += 2.0 * cosine * share(roughness, cosine, int_ior, ext_ior, Way::reflected) / kNodes;
  }
}

double RoughCoat::transmittance(double cosine) const {
  const double x = std::clamp(cosine, 0.0, 1.0) * (kNodes - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(x), kNodes - 2);
  const double t = x - static_cast<double>(i);
  return (1.0 - t) * nodes_[i] + t * nodes_[i + 1];
}

CoatAt::CoatAt(Roughness::Distribution distribution, const ScalarParameter& alpha, double int_ior, double ext_ior) {
  const auto coat = [&](double roughness) {
    return &rough_coat({distribution, roughness, roughness}, int_ior, ext_ior);
  };
  if (!alpha.texture) {
    lower_ = upper_ = coat(alpha.value);
    return;
  }
  constexpr int kLast = 15;
  const auto node = [](int i) { return std::max(kMinRoughness, static_cast<double>(i * i) / (kLast * kLast)); };
  const double place = std::sqrt(alpha.value) * kLast;
  const int i = std::min(static_cast<int>(place), kLast - 1);
  way_ = place - i;
  lower_ = coat(node(i));
  upper_ = coat(node(i + 1));
}

Vec3 coated_base(const Vec3& albedo, bool nonlinear, double inside, double ratio, double enters, double leaves,
                 double cos_i) {
  // Radiance that leaves the coat shrinks by (n_outside / n_inside)²; 1/(1 − inside) sums the repeated reflections.
  const Vec3 again = nonlinear ? albedo * inside : Vec3(inside);
  return albedo / (Vec3(1.0) - again) * (ratio * ratio * enters * leaves * cos_i / kPi);
}

}  // namespace etendue::reference
