// A pane of glass without thickness. With multiple reflections between its two faces, it reflects 2F/(1 + F).
#include "../fresnel.glsl"
#include "../mutants.h"

BsdfSample thindielectric_sample(Material m, vec3 wo, float u_lobe) {
  if (wo.z == 0.0) return kNoBsdfSample;
  float cos_t;
  const float once = fresnel_dielectric(abs(wo.z), m.int_ior / m.ext_ior, cos_t);
  float reflectance = 2.0 * once / (1.0 + once);
  MUTATE(kMutantPaneReflectsOnce, reflectance = once);
  if (u_lobe < reflectance) return BsdfSample(vec3(-wo.xy, wo.z), reflectance, m.specular, kLobeDeltaReflection, 1.0);
  return BsdfSample(-wo, 1.0 - reflectance, m.albedo, kLobeDeltaTransmission, 1.0);
}
