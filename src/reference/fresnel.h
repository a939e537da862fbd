#pragma once
/// Reflection and refraction at a smooth boundary between two dielectrics.

#include <algorithm>
#include <cmath>
#include <complex>

#include "reference/vec.h"

namespace etendue::reference {

struct Fresnel {
  double reflectance = 1.0;    ///< unpolarised, [0,1]; 1 under total internal reflection
  double cos_transmitted = 0;  ///< >= 0, in the other medium; 0 under total internal reflection
};

/// Exact equations for light arriving in a medium of index `n_o` at a boundary to `n_i`, with the angle's cosine
/// `cos_o` in [0,1]. Source: [Born1999], §1.5.2, equations 21 and 21a.
inline Fresnel fresnel_dielectric(double cos_o, double n_o, double n_i) {
  const double ratio = n_o / n_i;
  const double sin2_t = ratio * ratio * std::max(0.0, 1.0 - cos_o * cos_o);
  if (sin2_t >= 1.0) return {};
  const double cos_t = std::sqrt(1.0 - sin2_t);
  const double perpendicular = (n_o * cos_o - n_i * cos_t) / (n_o * cos_o + n_i * cos_t);
  const double parallel = (n_i * cos_o - n_o * cos_t) / (n_i * cos_o + n_o * cos_t);
  return {0.5 * (perpendicular * perpendicular + parallel * parallel), cos_t};
}

/// Unpolarised reflectance of a metal of index `eta` + ik, seen from a medium of index 1 at an angle of cosine `cos_o`
/// in [0,1]. Source: [Born1999], §14.2, by complex arithmetic.
inline double fresnel_conductor(double cos_o, double eta, double k) {
  const std::complex<double> index(eta, k), squared = index * index;
  const std::complex<double> bent = std::sqrt(squared - (1.0 - cos_o * cos_o));  // n cos θ in the metal
  const std::complex<double> perpendicular = (cos_o - bent) / (cos_o + bent);
  const std::complex<double> parallel = (squared * cos_o - bent) / (squared * cos_o + bent);
  return 0.5 * (std::norm(perpendicular) + std::norm(parallel));
}
inline Vec3 fresnel_conductor(double cos_o, const Vec3& eta, const Vec3& k) {
  return {fresnel_conductor(cos_o, eta.x, k.x), fresnel_conductor(cos_o, eta.y, k.y),
          fresnel_conductor(cos_o, eta.z, k.z)};
}

}  // namespace etendue::reference
