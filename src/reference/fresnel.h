#pragma once
/// Reflection and refraction at a smooth boundary between two dielectrics.

#include <algorithm>
#include <cmath>

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

}  // namespace etendue::reference
