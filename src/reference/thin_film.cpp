#include "reference/thin_film.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reference/burley_base.h"

namespace etendue::reference {
namespace {

/// Index of a dielectric that reflects this share along the normal.
double index_of(double reflectance) {
  const double root = std::sqrt(std::min(reflectance, 0.9999));
  return (1.0 + root) / (1.0 - root);
}
double normal_reflectance(double n1, double n2) {
  return (n1 - n2) * (n1 - n2) / ((n1 + n2) * (n1 + n2));
}
double schlick(double normal, double cosine) {
  return normal + (1.0 - normal) * schlick_weight(cosine);
}

/// A Gaussian of wave numbers, and its Fourier transform.
struct Band {
  double peak, place, width;
  double transform(double phase, double shift) const {
    return peak * std::sqrt(2.0 * kPi * width) * std::cos(place * phase + shift) * std::exp(-width * phase * phase);
  }
};
constexpr std::array<Band, 4> kBands{{{5.4856e-13, 1.6810e6, 4.3278e9},
                                      {4.4201e-13, 1.7953e6, 9.3046e9},
                                      {5.2481e-13, 2.2084e6, 6.6121e9},
                                      {9.7470e-14, 2.2399e6, 4.5282e9}}};  // X, Y, Z, and more of X

Vec3 sensitivity(double path, const Vec3& shift) {
  const double phase = 2.0 * kPi * path * 1e-9;
  Vec3 xyz;
  for (int c = 0; c < 3; ++c) xyz[c] = kBands[c].transform(phase, shift[c]);
  xyz.x += kBands[3].transform(phase, shift.x);
  const glm::dmat3 rec709_from_xyz(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314,
                                   0.0415560, 1.0572252);
  return rec709_from_xyz * xyz / 1.0685e-7;
}

}  // namespace

Vec3 ThinFilm::bound() const {
  Vec3 most;
  for (int c = 0; c < 3; ++c) {
    const double above = std::sqrt(normal_reflectance(1.0, index));
    const double below = std::sqrt(normal_reflectance(index, index_of(normal[c])));
    most[c] = std::pow((above + below) / (1.0 + above * below), 2);
  }
  return most;
}

Vec3 ThinFilm::reflectance(double cosine) const {
  const double s = std::clamp(thickness / 0.03, 0.0, 1.0);  // no film, no index
  const double n = 1.0 + (index - 1.0) * s * s * (3.0 - 2.0 * s);
  const double inner = std::sqrt(std::max(0.0, 1.0 - (1.0 - cosine * cosine) / (n * n)));
  const double r12 = schlick(normal_reflectance(1.0, n), cosine), passed = 1.0 - r12;
  Vec3 r23(0.0), shift(0.0);
  for (int c = 0; c < 3; ++c) {
    const double base = index_of(normal[c]);
    r23[c] = schlick(normal_reflectance(n, base), inner);
    shift[c] = base < n ? 2.0 * kPi : kPi;  // π within the film's upper face, and π below where the index rises no more
  }
  const double path = 2.0 * n * thickness * inner;
  const Vec3 both = glm::clamp(r12 * r23, 1e-5, 0.9999), sum = passed * passed * r23 / (1.0 - both);
  Vec3 reflected = r12 + sum, term = sum - passed;
  for (int m = 1; m <= 2; ++m) {
    term *= glm::sqrt(both);
    reflected += 2.0 * term * sensitivity(m * path, static_cast<double>(m) * shift);
  }
  return glm::clamp(reflected, Vec3(0.0), reference::schlick(bound(), cosine));
}

}  // namespace etendue::reference
