// The integrators that look only at the first surface: normals, depth, distance, simple, ao, av; docs/conventions.md, "Integrators".
#ifndef FIRST_HIT_GLSL
#define FIRST_HIT_GLSL

#include "../warp.glsl"

// A point light used only by this integrator: Φ/(4π²) cos θ/d² if nothing is in between.
void shade_simple(inout Path path, Surface s) {
  const vec3 v = frame.light_position - s.p;
  const float d2 = dot(v, v);
  const float cos_theta = dot(v, s.frame.n) / sqrt(d2);
  const vec3 o = offset_origin(s.p, s.ng, s.error, v);
  const vec3 to_light = frame.light_position - o;
  const float distance = length(to_light);
  path.shadow_ray = Ray(o, 0.0, to_light * (1.0 / distance), distance * (1.0 - 1e-6));
  path.shadow_value = frame.light_intensity * (cos_theta / d2);
  MUTATE(kMutantSimpleCosineDropped, path.shadow_value = frame.light_intensity / d2);
  path.shadow_pending = cos_theta > 0.0;
}

// One ray of the hemisphere about the shading normal, up to a length.
void shade_occlusion(inout Path path, Surface s) {
  const vec2 u = to_unit(random_words(frame.seed, path.pixel, path.sample_index, block_bsdf(0u)).yz);
  vec3 w = kIntegrator == kIntegratorVisibility ? square_to_cone(u, 1.0) : square_to_cosine_hemisphere(u);
  MUTATE(kMutantOcclusionWarpsSwapped, w = kIntegrator == kIntegratorVisibility ? square_to_cosine_hemisphere(u) : square_to_cone(u, 1.0));
  Ray ray = spawn_ray(s.p, s.ng, s.error, to_world(s.frame, w));
  ray.t_max = frame.ray_length;
  MUTATE(kMutantOcclusionEndless, ray.t_max = kInfinity);
  path.shadow_ray = ray;
  path.shadow_value = vec3(1.0);
  path.shadow_pending = true;
}

void shade_first_hit(inout Path path, Surface s, Hit hit) {
  if (kIntegrator == kIntegratorNormals) path.radiance += path.beta * (0.5 * s.frame.n + 0.5);
  if (kIntegrator == kIntegratorAbsoluteNormals) path.radiance += abs(s.frame.n);
  if (kIntegrator == kIntegratorDepth) path.radiance += vec3(frame.distance_scale / (hit.t + camera_ray_start(path.ray.d)));
  if (kIntegrator == kIntegratorDistance) {
    const float before_start = frame.ray_length * camera_ray_start(path.ray.d);
    path.radiance += vec3((hit.t - path.ray.t_min + before_start) / frame.distance_scale);
  }
  if (kIntegrator == kIntegratorSimple) shade_simple(path, s);
  if (kIntegrator == kIntegratorAmbientOcclusion || kIntegrator == kIntegratorVisibility) shade_occlusion(path, s);
}

#endif
