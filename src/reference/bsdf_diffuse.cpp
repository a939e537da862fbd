/// Lambertian reflection: f = albedo / π on the side of the normal.

#include "reference/bsdf.h"
#include "reference/sampling.h"

namespace etendue::reference {

Vec3 eval(const DiffuseBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return Vec3(0.0);
  return bsdf.albedo.value * (wi.z / kPi);
}

double pdf(const DiffuseBsdf&, const Vec3& wo, const Vec3& wi) {
  return wo.z <= 0.0 || wi.z <= 0.0 ? 0.0 : wi.z / kPi;
}

BsdfSample sample(const DiffuseBsdf& bsdf, const Vec3& wo, double, const Vec2& u) {
  if (wo.z <= 0.0) return {};
  const Vec3 wi = square_to_cosine_hemisphere(u);
  const double density = pdf(bsdf, wo, wi);
  if (density == 0.0) return {};
  // eval / pdf: the cosine and π cancel.
  return {.wi = wi, .weight = bsdf.albedo.value, .pdf = density, .lobe = Lobe::diffuse_reflection};
}

}  // namespace etendue::reference
