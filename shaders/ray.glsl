// Rays, and how they leave a surface.
#ifndef RAY_GLSL
#define RAY_GLSL

#include "math.glsl"
#include "mutants.h"

struct Ray {
  vec3 o;
  float t_min;
  vec3 d;  // unit length
  float t_max;
};

// Ray from a surface point into direction d. `error` bounds the distance of p from the true surface plus the error of the next
// intersection test (see surface_error): the origin moves that far along ng to the side d leaves to, so there is no global epsilon.
vec3 offset_origin(vec3 p, vec3 ng, float error, vec3 d) { return p + (dot(d, ng) >= 0.0 ? error : -error) * ng; }

Ray spawn_ray(vec3 p, vec3 ng, float error, vec3 d) { return Ray(offset_origin(p, ng, error, d), 0.0, d, kInfinity); }

// Shadow ray between two surface points that are offset alike, so that neither surface occludes its own point.
Ray spawn_shadow_ray(vec3 p, vec3 ng, float error, vec3 target, vec3 target_ng, float target_error) {
  const vec3 o = offset_origin(p, ng, error, target - p);
  const vec3 v = offset_origin(target, target_ng, target_error, p - target) - o;
  const float distance = length(v);
  const vec3 d = v * (1.0 / distance);
  MUTATE(kMutantShadowRayTooLong, return Ray(o, 0.0, d, distance * 1.01));
  MUTATE(kMutantShadowsIgnored, return Ray(o, 0.0, d, 0.0));
  return Ray(o, 0.0, d, distance * (1.0 - 1e-6));
}

#endif
