#pragma once
/// Tables for clear coats over a diffuse base; docs/conventions.md, "Coats".

#include <array>
#include <vector>

#include "gpu_types.h"
#include "scene/bsdfs.h"

namespace etendue {

/// Fraction of diffuse light from inside that a smooth boundary of relative index `eta` (interior over exterior, > 1)
/// reflects back inside; fit by [dEon2011].
double diffuse_reflectance_inside(double eta);

struct RoughCoat {
  std::array<float, gpu::kTransmittanceNodes> transmittances{};  ///< from outside, at cosines evenly spaced over [0, 1]
  double reflectance_inside = 0.0;                               ///< for diffuse light from inside
};
RoughCoat rough_coat(const Roughness& roughness, double eta);

/// Albedo of white sheen at kSheenCosines cosines evenly spaced over [0, 1] (the first is 1e-3), for each of
/// kSheenRoughnesses roughnesses evenly spaced over [0.1, 1]; docs/conventions.md, "glTF".
std::vector<float> sheen_albedos();

}  // namespace etendue
