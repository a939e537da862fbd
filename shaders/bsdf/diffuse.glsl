// Lambertian reflection, one-sided [Lambert1760].
#include "../mutants.h"
#include "../warp.glsl"

float diffuse_pdf(vec3 wo, vec3 wi) { return wo.z > 0.0 && wi.z > 0.0 ? kInvPi * wi.z : 0.0; }

Scattering diffuse_evaluate(Material m, vec3 wo, vec3 wi) {
  const float pdf = diffuse_pdf(wo, wi);
  MUTATE(kMutantCosineDropped, return Scattering(pdf > 0.0 ? m.albedo * kInvPi : vec3(0.0), pdf));
  MUTATE(kMutantBlackSideLit, return Scattering(m.albedo * (kInvPi * abs(wi.z)), pdf));
  return Scattering(m.albedo * pdf, pdf);
}

BsdfSample diffuse_sample(Material m, vec3 wo, vec2 u) {
  const vec3 wi = square_to_cosine_hemisphere(u);
  const float pdf = diffuse_pdf(wo, wi);
  if (pdf == 0.0) return kNoBsdfSample;
  MUTATE(kMutantBsdfPdfScaled, return BsdfSample(wi, 1.02 * pdf, m.albedo / 1.02, kLobeDiffuse, 1.0));
  return BsdfSample(wi, pdf, m.albedo, kLobeDiffuse, 1.0);
}
