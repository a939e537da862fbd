#include "reference/sheen.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reference/vec.h"

namespace etendue::reference {
namespace {

constexpr int kCosines = 32, kRoughnesses = 16;
constexpr double kLeast = 0.1;

/// Λ of the shadowing, by the fit of [Estevez2017], eq. 3 and table 1.
double lambda(double cosine, double alpha) {
  constexpr std::array<double, 5> kSmooth{25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
  constexpr std::array<double, 5> kRough{21.5473, 3.82987, 0.19823, -1.97760, -4.32054};
  const double t = (1.0 - alpha) * (1.0 - alpha);
  std::array<double, 5> p;
  for (std::size_t i = 0; i < 5; ++i) p[i] = t * kSmooth[i] + (1.0 - t) * kRough[i];
  const auto l = [&](double x) { return p[0] / (1.0 + p[1] * std::pow(x, p[2])) + p[3] * x + p[4]; };
  return cosine < 0.5 ? std::exp(l(cosine)) : std::exp(2.0 * l(0.5) - l(1.0 - cosine));
}

/// Of the fibres' normals.
double density(double alpha, double sin_h) {
  return (2.0 + 1.0 / alpha) * std::pow(sin_h, 1.0 / alpha) / (2.0 * kPi);
}
/// Shadowing over 4 cos θ_o.
double visibility(double alpha, double cos_o, double cos_i) {
  return 1.0 / (4.0 * cos_o * (1.0 + lambda(cos_o, alpha) + lambda(cos_i, alpha)));
}

/// Simpson's rule over θ_i, whose square root is even because the lobe lies at the horizon, and half a turn.
double exact_albedo(double alpha, double cos_o) {
  constexpr int kRings = 120, kSectors = 60;
  const auto simpson = [](int i, int n) { return i == 0 || i == n ? 1.0 : i % 2 == 1 ? 4.0 : 2.0; };
  const Vec3 wo(std::sqrt(1.0 - cos_o * cos_o), 0.0, cos_o);
  double sum = 0.0;
  for (int i = 1; i <= kRings; ++i) {
    const double x = static_cast<double>(i) / kRings, cos_i = x * x;  // d cos = 2 x dx
    const double sin_i = std::sqrt(std::max(0.0, 1.0 - cos_i * cos_i));
    const double ring = simpson(i, kRings) * 2.0 * x * visibility(alpha, cos_o, cos_i);
    for (int j = 0; j <= kSectors; ++j) {
      const double phi = kPi * j / kSectors;
      const Vec3 h = wo + Vec3(sin_i * std::cos(phi), sin_i * std::sin(phi), cos_i);
      sum += ring * simpson(j, kSectors) * density(alpha, std::hypot(h.x, h.y) / glm::length(h));
    }
  }
  return 2.0 * sum * kPi / (9.0 * kRings * kSectors);
}

using Table = std::array<std::array<double, kCosines>, kRoughnesses>;

Table make_table() {
  Table table;
  for (int row = 0; row < kRoughnesses; ++row) {
    const double roughness = kLeast + (1.0 - kLeast) * row / (kRoughnesses - 1);
    for (int i = 0; i < kCosines; ++i) {
      const double cosine = std::max(1e-3, static_cast<double>(i) / (kCosines - 1));
      table[row][i] = 1.02 * exact_albedo(roughness * roughness, cosine) + 0.002;
    }
  }
  return table;
}

}  // namespace

Sheen::Sheen(double roughness) : alpha_(std::max(kLeast, roughness) * std::max(kLeast, roughness)) {}

double Sheen::lobe(double cos_o, double cos_i, double cos_h) const {
  return density(alpha_, std::sqrt(std::max(0.0, 1.0 - cos_h * cos_h))) * visibility(alpha_, cos_o, cos_i);
}

double Sheen::albedo(double cosine) const {
  static const Table table = make_table();
  const double x = std::min(1.0, cosine) * (kCosines - 1);
  const double y = (std::sqrt(alpha_) - kLeast) / (1.0 - kLeast) * (kRoughnesses - 1);
  const int i = std::min(static_cast<int>(x), kCosines - 2), row = std::clamp(static_cast<int>(y), 0, kRoughnesses - 2);
  const auto at = [&](int r) { return table[r][i] + (x - i) * (table[r][i + 1] - table[r][i]); };
  return at(row) + (y - row) * (at(row + 1) - at(row));
}

}  // namespace etendue::reference
