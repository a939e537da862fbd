/// A pane whose two faces coincide: light is reflected back and forth between them, without displacement.

#include "reference/bsdf.h"
#include "reference/fresnel.h"

namespace etendue::reference {

Vec3 eval(const ThinDielectricBsdf&, const Vec3&, const Vec3&) {
  return Vec3(0.0);
}

double pdf(const ThinDielectricBsdf&, const Vec3&, const Vec3&) {
  return 0.0;
}

BsdfSample sample(const ThinDielectricBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2&) {
  if (wo.z == 0.0) return {};
  const double face = fresnel_dielectric(std::abs(wo.z), bsdf.ext_ior, bsdf.int_ior).reflectance;
  // The geometric series F + T²F + T²F³ + …, T = 1 − F.
  const double pane = face + (1.0 - face) * face / (1.0 + face);
  if (u_lobe < pane) {
    return {.wi = {-wo.x, -wo.y, wo.z},
            .weight = bsdf.specular_reflectance.value,
            .pdf = pane,
            .lobe = Lobe::delta_reflection};
  }
  return {.wi = -wo, .weight = bsdf.specular_transmittance.value, .pdf = 1.0 - pane, .lobe = Lobe::delta_transmission};
}

}  // namespace etendue::reference
