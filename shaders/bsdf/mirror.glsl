// Perfect specular reflection, reflectance 1, one-sided.

BsdfSample mirror_sample(vec3 wo) {
  if (wo.z <= 0.0) return kNoBsdfSample;
  return BsdfSample(vec3(-wo.xy, wo.z), 1.0, vec3(1.0), kLobeDeltaReflection, 1.0);
}
