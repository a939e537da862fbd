/// Rough metal: f = F D G / (4 cos θ_o cos θ_i) [Walter2007, eq. 20], G the product of both directions' masking.

#include "reference/bsdf.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"

namespace etendue::reference {

Vec3 eval(const RoughConductorBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return Vec3(0.0);
  const MicrofacetDistribution facets(bsdf.roughness);
  const Vec3 h = glm::normalize(wo + wi);
  const double f = facets.density(h) * facets.masking(wo, h) * facets.masking(wi, h) / (4.0 * wo.z * wi.z);
  return bsdf.specular_reflectance.value *
         fresnel_conductor(glm::dot(wo, h), bsdf.index.eta.value, bsdf.index.k.value) * (f * wi.z);
}

double pdf(const RoughConductorBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return 0.0;
  const Vec3 h = glm::normalize(wo + wi);
  return MicrofacetDistribution(bsdf.roughness).visible_density(wo, h) / (4.0 * glm::dot(wo, h));
}

BsdfSample sample(const RoughConductorBsdf& bsdf, const Vec3& wo, double, const Vec2& u) {
  if (wo.z <= 0.0) return {};
  const Vec3 h = MicrofacetDistribution(bsdf.roughness).sample_visible(wo, u);
  const Vec3 wi = 2.0 * glm::dot(wo, h) * h - wo;
  return weighed_by_all_lobes(bsdf, wo, wi, Lobe::glossy_reflection);
}

}  // namespace etendue::reference
