/// Smooth boundary between two dielectrics; the normal points to the exterior.

#include "reference/bsdf.h"
#include "reference/fresnel.h"

namespace etendue::reference {

Vec3 eval(const DielectricBsdf&, const Vec3&, const Vec3&) {
  return Vec3(0.0);
}

double pdf(const DielectricBsdf&, const Vec3&, const Vec3&) {
  return 0.0;
}

BsdfSample sample(const DielectricBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2&) {
  if (wo.z == 0.0) return {};
  const bool outside = wo.z > 0.0;
  const double n_o = outside ? bsdf.ext_ior : bsdf.int_ior;
  const double n_i = outside ? bsdf.int_ior : bsdf.ext_ior;
  const Fresnel fresnel = fresnel_dielectric(std::abs(wo.z), n_o, n_i);
  if (u_lobe < fresnel.reflectance) {
    return {.wi = {-wo.x, -wo.y, wo.z},
            .weight = bsdf.specular_reflectance.value,
            .pdf = fresnel.reflectance,
            .lobe = Lobe::delta_reflection};
  }
  // Snell: the tangential part shrinks by n_o/n_i. Radiance is proportional to the squared index of its medium, and the
  // path carries the radiance on the side of `wo` back to the camera [Veach1997, §5.2].
  const double ratio = n_o / n_i;
  const Vec3 wi(-ratio * wo.x, -ratio * wo.y, outside ? -fresnel.cos_transmitted : fresnel.cos_transmitted);
  return {.wi = glm::normalize(wi),
          .weight = ratio * ratio * bsdf.specular_transmittance.value,
          .pdf = 1.0 - fresnel.reflectance,
          .lobe = Lobe::delta_transmission,
          .eta = n_i / n_o};
}

}  // namespace etendue::reference
