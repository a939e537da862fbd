/// Smooth metal: a mirror that reflects by Fresnel's equations.

#include "reference/bsdf.h"
#include "reference/fresnel.h"

namespace etendue::reference {

Vec3 eval(const ConductorBsdf&, const Vec3&, const Vec3&) {
  return Vec3(0.0);
}

double pdf(const ConductorBsdf&, const Vec3&, const Vec3&) {
  return 0.0;
}

BsdfSample sample(const ConductorBsdf& bsdf, const Vec3& wo, double, const Vec2&) {
  if (wo.z <= 0.0) return {};
  return {.wi = {-wo.x, -wo.y, wo.z},
          .weight = bsdf.specular_reflectance.value * fresnel_conductor(wo.z, bsdf.index.eta.value, bsdf.index.k.value),
          .pdf = 1.0,
          .lobe = Lobe::delta_reflection};
}

}  // namespace etendue::reference
