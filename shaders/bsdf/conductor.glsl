// Smooth metal: a mirror that reflects by Fresnel's equations, one-sided.
#include "../fresnel.glsl"
#include "../mutants.h"

BsdfSample conductor_sample(Material m, vec3 wo) {
  if (wo.z <= 0.0) return kNoBsdfSample;
  vec3 reflectance = fresnel_conductor(wo.z, m.eta, m.k);
  MUTATE(kMutantConductorNormalIncidence, reflectance = fresnel_conductor(1.0, m.eta, m.k));
  return BsdfSample(vec3(-wo.xy, wo.z), 1.0, m.specular * reflectance, kLobeDeltaReflection, 1.0);
}
