// Perfect specular reflection, reflectance 1, one-sided.
#include "../mutants.h"

BsdfSample mirror_sample(vec3 wo) {
  if (wo.z <= 0.0) return kNoBsdfSample;
  MUTATE(kMutantMirrorHalfTurned, return BsdfSample(vec3(-wo.x, wo.yz), 1.0, vec3(1.0), kLobeDeltaReflection, 1.0));
  return BsdfSample(vec3(-wo.xy, wo.z), 1.0, vec3(1.0), kLobeDeltaReflection, 1.0);
}
