// AOVs; docs/conventions.md, "AOVs". They take the same path as light in path.glsl, so masks, hidden emitters and maps are the same as in the
// picture.
#ifndef AOV_GLSL
#define AOV_GLSL

// Weight of a sample's value: that of the picture's filter if all samples are averaged. For values that are not averaged, the first path of a set
// counts.
float aov_weight(Path path) {
  if (frame.aov >= kAovInstance && frame.aov <= kAovMaterial) {
    const uint mask = (1u << kSetBits) - 1u;
    MUTATE(kMutantAovSetSummed, return float(mask + 1u));
    return (path.sample_index & mask) == 0u ? float(mask + 1u) : 0.0;
  }
  const bool over_hits = frame.aov == kAovHit || frame.aov == kAovDepth || frame.aov == kAovPosition || frame.aov == kAovUv;
  if (over_hits) return 1.0;
  MUTATE(kMutantAovFilterIgnored, return 1.0);
  return kCamera == kCameraIrradiance ? path.filter_weight / kPi : path.filter_weight;
}

// Two halves of 16 bits, which floats hold exactly.
vec3 number_value(uint number) { return vec3(float(number & 0xffffu), float(number >> 16u), 0.0); }

// The ray may have passed hidden emitters, restarting behind each of them.
float distance_to_camera(Path path, Surface s) {
  float weight;
  uint sample_index = path.sample_index;
  MUTATE(kMutantAovOtherSample, ++sample_index);
  const Ray ray = camera_ray(path.pixel, film_place(path.pixel), sample_index, weight);
  return (dot(s.p - ray.o, ray.d) + camera_ray_start(ray.d)) / frame.distance_scale;
}

vec2 first_uv(SurfacePoint at) {
  if (kTextureFeatures == 0u) return vec2(0.0);
  const InstanceAttributes a = fetch_instance_attributes(at.instance);
  const bool has = (a.layout_bits & (kAttributesSetsMask | kAttributesSphere | kAttributesDisk | kAttributesCylinder)) != 0u;
  return has ? surface_uv(a, at, 0u) : vec2(0.0);
}

// The AOVs that are known where the ray arrives.
vec3 value_at_hit(Path path, Surface s, Instance instance, SurfacePoint at) {
  if (frame.aov == kAovDepth) return vec3(distance_to_camera(path, s), 0.0, 0.0);
  MUTATE(kMutantAovPlaceNotMoved, if (frame.aov == kAovPosition) return s.p / frame.distance_scale);
  if (frame.aov == kAovPosition) return s.p / frame.distance_scale + frame.scene_center;
  if (frame.aov == kAovShadingNormal) return s.frame.n;
  if (frame.aov == kAovGeometricNormal) return s.ng;
  if (frame.aov == kAovUv) return vec3(first_uv(at), 0.0);
  if (frame.aov == kAovInstance) return number_value(s.instance + 1u);
  if (frame.aov == kAovPrimitive) return number_value(s.primitive + 1u);
  if (frame.aov == kAovMaterial) return number_value(instance.material + 1u);
  return vec3(1.0);
}

// Lamps and sky contribute their colour, up to white.
void see_emission(inout Path path, vec3 le) {
  if (frame.aov == kAovAlbedo) path.radiance = max(path.radiance, min(path.beta * le, 1.0));
}

// At the first vertex that is neither mirror nor glass: its reflectance, by one sample of the material.
void end_at_albedo(inout Path path, Decisions decisions) {
  if (decisions.lobe != kLobeNone) path.radiance = max(path.radiance, min(path.beta, 1.0));
  path.alive = false;
}

#endif
