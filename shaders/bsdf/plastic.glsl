// A diffuse base inside a clear coat: light enters, is scattered below, and leaves. docs/conventions.md, "Coats".
#include "../fresnel.glsl"
#include "../mutants.h"
#include "../warp.glsl"

// f cos of the base, lit and seen through the coat, which transmits `in_share` on the way in and `out_share` on the way
// out.
vec3 coated_base(Material m, float cos_i, float in_share, float out_share) {
  const float inside = m.k.x;
  vec3 lost = vec3(inside);
  if (material_has(m, kMaterialNonlinear)) lost *= m.albedo;
  MUTATE(kMutantInnerReflectionForgotten, lost = vec3(0.0));
  return m.albedo / (1.0 - lost) * (kInvPi * cos_i * m.k.y * in_share * out_share);
}

float plastic_passes(Material m, float cosine) {
  float cos_t;
  return 1.0 - fresnel_dielectric(cosine, m.int_ior / m.ext_ior, cos_t);
}

// Fraction of the samples for the coat, where it transmits the fraction `passes`.
float coat_share(Material m, float passes) {
  const float coat = (1.0 - passes) * m.share;
  return coat / (coat + passes * (1.0 - m.share));
}

Scattering plastic_evaluate(Material m, vec3 wo, vec3 wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return kNoScattering;
  const float passes = plastic_passes(m, wo.z);
  return Scattering(coated_base(m, wi.z, plastic_passes(m, wi.z), passes), (1.0 - coat_share(m, passes)) * (kInvPi * wi.z));
}

BsdfSample plastic_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  if (wo.z <= 0.0) return kNoBsdfSample;
  const float passes = plastic_passes(m, wo.z);
  const float share = coat_share(m, passes);
  if (u_lobe < share) return BsdfSample(vec3(-wo.xy, wo.z), share, m.specular * ((1.0 - passes) / share), kLobeDeltaReflection, 1.0);
  const vec3 wi = square_to_cosine_hemisphere(u);
  const float pdf = (1.0 - share) * (kInvPi * wi.z);
  return BsdfSample(wi, pdf, coated_base(m, wi.z, plastic_passes(m, wi.z), passes) / pdf, kLobeDiffuse, 1.0);
}
