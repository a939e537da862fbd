// Smooth dielectric: exact Fresnel choice between reflection and refraction; the normal points to the exterior.
#include "../fresnel.glsl"
#include "../mutants.h"

BsdfSample dielectric_sample(Material m, vec3 wo, float u_lobe) {
  if (wo.z == 0.0) return kNoBsdfSample;
  const bool outside = wo.z > 0.0;
  const float n_o = outside ? m.ext_ior : m.int_ior;
  const float n_i = outside ? m.int_ior : m.ext_ior;  // of the refracted wi
  const float eta = n_i / n_o;
  const float inv_eta = n_o / n_i;
  float cos_t;
  float reflectance = fresnel_dielectric(abs(wo.z), eta, cos_t);
  MUTATE(kMutantFresnelSwapped, reflectance = cos_t > 0.0 ? 1.0 - reflectance : 1.0);
  if (u_lobe < reflectance) return BsdfSample(vec3(-wo.xy, wo.z), reflectance, vec3(1.0), kLobeDeltaReflection, 1.0);
  // Snell: the tangential part shrinks by 1/eta. What is carried is radiance, which scales with (n_o/n_i)².
  const vec3 wi = vec3(-wo.xy * inv_eta, outside ? -cos_t : cos_t);
  MUTATE(kMutantEtaOmitted, return BsdfSample(wi, 1.0 - reflectance, vec3(1.0), kLobeDeltaTransmission, 1.0));
  MUTATE(kMutantEtaInverted, return BsdfSample(wi, 1.0 - reflectance, vec3(eta * eta), kLobeDeltaTransmission, 1.0 / (eta * eta)));
  MUTATE(kMutantSnellIgnored, return BsdfSample(-wo, 1.0 - reflectance, vec3(inv_eta * inv_eta), kLobeDeltaTransmission, eta * eta));
  return BsdfSample(wi, 1.0 - reflectance, vec3(inv_eta * inv_eta), kLobeDeltaTransmission, eta * eta);
}

BsdfSample tinteddielectric_sample(Material m, vec3 wo, float u_lobe) {
  BsdfSample s = dielectric_sample(m, wo, u_lobe);
  vec3 tint = s.lobe == kLobeDeltaTransmission ? m.albedo : m.specular;
  MUTATE(kMutantTintOnce, tint = m.specular);
  s.weight *= tint;
  return s;
}
