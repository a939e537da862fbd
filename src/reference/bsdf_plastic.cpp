/// A diffuse base inside a smooth clear coat.

#include "reference/bsdf.h"
#include "reference/coat.h"
#include "reference/fresnel.h"
#include "reference/sampling.h"

namespace etendue::reference {
namespace {

double mean(const Vec3& color) {
  return (color.x + color.y + color.z) / 3.0;
}
double coat_reflects(const PlasticBsdf& bsdf, double cosine) {
  return fresnel_dielectric(cosine, bsdf.ext_ior, bsdf.int_ior).reflectance;
}
/// Probability of sampling the coat, in proportion to the estimated reflectances of coat and base.
double coat_prob(const PlasticBsdf& bsdf, double cos_o) {
  const double f = coat_reflects(bsdf, cos_o);
  const double coat = f * mean(bsdf.specular_reflectance.value),
               base = (1.0 - f) * mean(bsdf.diffuse_reflectance.value);
  return coat + base > 0.0 ? coat / (coat + base) : 1.0;
}

}  // namespace

Vec3 eval(const PlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return Vec3(0.0);
  return coated_base(bsdf.diffuse_reflectance.value, bsdf.nonlinear,
                     diffuse_reflectance_inside(bsdf.int_ior, bsdf.ext_ior), bsdf.ext_ior / bsdf.int_ior,
                     1.0 - coat_reflects(bsdf, wi.z), 1.0 - coat_reflects(bsdf, wo.z), wi.z);
}

double pdf(const PlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return 0.0;
  return (1.0 - coat_prob(bsdf, wo.z)) * wi.z / kPi;
}

BsdfSample sample(const PlasticBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  if (wo.z <= 0.0) return {};
  const double prob = coat_prob(bsdf, wo.z);
  if (u_lobe < prob) {
    return {.wi = {-wo.x, -wo.y, wo.z},
            .weight = bsdf.specular_reflectance.value * (coat_reflects(bsdf, wo.z) / prob),
            .pdf = prob,
            .lobe = Lobe::delta_reflection};
  }
  const Vec3 wi = square_to_cosine_hemisphere(u);
  return weighed_by_all_lobes(bsdf, wo, wi, Lobe::diffuse_reflection);
}

}  // namespace etendue::reference
