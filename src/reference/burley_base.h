#pragma once
/// Common parts of Burley's materials: the diffuse base and the sheen over it, the tint, Schlick's reflectance.

#include "reference/vec.h"
#include "scene/bsdfs.h"

namespace etendue::reference {

/// (1 − x)⁵ [Schlick1994].
double schlick_weight(double cosine);
/// Schlick's reflectance, from that at normal incidence.
Vec3 schlick(const Vec3& normal, double cosine);
/// A colour of luminance 1; white for black.
Vec3 tint_of(const Vec3& color);
/// Roughness along and across the tangent.
Roughness burley_roughness(double roughness, double anisotropic);

/// Light that arrives at `cos_i` and leaves at `cos_o`; `cos_d` is the cosine to their half vector.
struct BurleyAngles {
  double cos_o, cos_i, cos_d;
};
/// f of a white base times π [Burley2012, §5.3; Burley2015, §4.1 for the flat one].
double burley_base(double roughness, double flatness, const BurleyAngles& angles);
/// f of a sheen of weight 1 in the tint of `color`.
Vec3 burley_sheen(double tinted, const Vec3& color, const BurleyAngles& angles);

}  // namespace etendue::reference
