/// A diffuse base inside a rough clear coat.

#include "reference/bsdf.h"
#include "reference/coat.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"
#include "reference/sampling.h"

namespace etendue::reference {
namespace {

Roughness roughness_of(const RoughPlasticBsdf& bsdf) {
  return {bsdf.distribution, bsdf.alpha, bsdf.alpha};
}
CoatAt coat_of(const RoughPlasticBsdf& bsdf) {
  return {bsdf.distribution, bsdf.alpha, bsdf.int_ior, bsdf.ext_ior};
}
double coat_prob(const RoughPlasticBsdf& bsdf, double cos_o) {
  const double enters = coat_of(bsdf).transmittance(cos_o);
  const Vec3 &s = bsdf.specular_reflectance.value, &d = bsdf.diffuse_reflectance.value;
  const double coat = (1.0 - enters) * (s.x + s.y + s.z), base = enters * (d.x + d.y + d.z);
  return coat + base > 0.0 ? coat / (coat + base) : 1.0;
}

}  // namespace

Vec3 eval(const RoughPlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return Vec3(0.0);
  const MicrofacetDistribution facets(roughness_of(bsdf));
  const Vec3 h = glm::normalize(wo + wi);
  const double fresnel = fresnel_dielectric(glm::dot(wo, h), bsdf.ext_ior, bsdf.int_ior).reflectance;
  const double coat = fresnel * facets.density(h) * facets.masking(wo, h) * facets.masking(wi, h) / (4.0 * wo.z);
  const CoatAt table = coat_of(bsdf);
  return bsdf.specular_reflectance.value * coat +
         coated_base(bsdf.diffuse_reflectance.value, bsdf.nonlinear, table.reflectance_inside(),
                     bsdf.ext_ior / bsdf.int_ior, table.transmittance(wi.z), table.transmittance(wo.z), wi.z);
}

double pdf(const RoughPlasticBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return 0.0;
  const Vec3 h = glm::normalize(wo + wi);
  const double prob = coat_prob(bsdf, wo.z);
  return prob * MicrofacetDistribution(roughness_of(bsdf)).visible_density(wo, h) / (4.0 * glm::dot(wo, h)) +
         (1.0 - prob) * wi.z / kPi;
}

BsdfSample sample(const RoughPlasticBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  if (wo.z <= 0.0) return {};
  const bool coat = u_lobe < coat_prob(bsdf, wo.z);
  Vec3 wi;
  if (coat) {
    const Vec3 h = MicrofacetDistribution(roughness_of(bsdf)).sample_visible(wo, u);
    wi = 2.0 * glm::dot(wo, h) * h - wo;
  } else {
    wi = square_to_cosine_hemisphere(u);
  }
  return weighed_by_all_lobes(bsdf, wo, wi, coat ? Lobe::glossy_reflection : Lobe::diffuse_reflection);
}

}  // namespace etendue::reference
