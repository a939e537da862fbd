/// A diffuse base under a coat of microfacets: f = kd/π + ks F D G / (4 cos θ_o cos θ_i), ks = 1 − max kd. This is the
/// convention of the teaching renderer Nori, which does not dim the base by the coat's reflection.

#include "reference/bsdf.h"
#include "reference/fresnel.h"
#include "reference/microfacet_distribution.h"
#include "reference/sampling.h"

namespace etendue::reference {
namespace {

MicrofacetDistribution distribution_of(const MicrofacetBsdf& bsdf) {
  return MicrofacetDistribution({Roughness::Distribution::beckmann, bsdf.alpha, bsdf.alpha});
}
double coat_share(const MicrofacetBsdf& bsdf) {
  return 1.0 - max_component(bsdf.kd.value);
}

}  // namespace

Vec3 eval(const MicrofacetBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return Vec3(0.0);
  const MicrofacetDistribution facets = distribution_of(bsdf);
  const Vec3 h = glm::normalize(wo + wi);
  const double fresnel = fresnel_dielectric(glm::dot(wo, h), bsdf.ext_ior, bsdf.int_ior).reflectance;
  const double shadowing = facets.masking(wo, h) * facets.masking(wi, h);
  const double coat = coat_share(bsdf) * fresnel * facets.density(h) * shadowing / (4.0 * wo.z * wi.z);
  return (bsdf.kd.value / kPi + Vec3(coat)) * wi.z;
}

double pdf(const MicrofacetBsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return 0.0;
  const Vec3 h = glm::normalize(wo + wi);
  const double coat = distribution_of(bsdf).visible_density(wo, h) / (4.0 * glm::dot(wo, h));
  const double ks = coat_share(bsdf);
  return ks * coat + (1.0 - ks) * wi.z / kPi;
}

BsdfSample sample(const MicrofacetBsdf& bsdf, const Vec3& wo, double u_lobe, const Vec2& u) {
  if (wo.z <= 0.0) return {};
  const bool coat = u_lobe < coat_share(bsdf);
  Vec3 wi;
  if (coat) {
    const Vec3 h = distribution_of(bsdf).sample_visible(wo, u);
    wi = 2.0 * glm::dot(wo, h) * h - wo;
  } else {
    wi = square_to_cosine_hemisphere(u);
  }
  return weighed_by_all_lobes(bsdf, wo, wi, coat ? Lobe::glossy_reflection : Lobe::diffuse_reflection);
}

}  // namespace etendue::reference
