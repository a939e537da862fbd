// Maps from the unit square to the shapes that are sampled; docs/conventions.md, "Warps", fixes each of them.
#ifndef WARP_GLSL
#define WARP_GLSL

#include "math.glsl"
#include "mutants.h"

// Unit disk, concentric map [Shirley1997]; pdf 1/π w.r.t. area. Each number stands for the middle of its cell of size
// 2^-24, so the rim is never reached, and everything here is exact in floats. |r| is the distance from the centre.
vec2 square_to_disk(vec2 u, out float r) {
  const vec2 ab = 2.0 * u - (1.0 - 1.0 / 16777216.0);
  const bool wide = abs(ab.x) > abs(ab.y);
  r = wide ? ab.x : ab.y;
  const float other = wide ? ab.y : ab.x;
  const vec2 cs = cos_sin_octant((0.25 * kPi) * (other / r));
  // cos(π/2 − x) = sin x: the second half of the map swaps the two.
  return r * (wide ? cs : cs.yx);
}

// Cosine-weighted direction about +Z; pdf_w = z/π, never 0.
vec3 square_to_cosine_hemisphere(vec2 u) {
  MUTATE(kMutantHemisphereUniform, return vec3(sqrt(max(0.0, 1.0 - u.x * u.x)) * cos_sin_turn(u.y), u.x));
  float r;
  const vec2 d = square_to_disk(u, r);
  return vec3(d, sqrt((1.0 - r) * (1.0 + r)));
}

// Weights of p0, p1, p2, uniform over the triangle's area [Turk1990].
vec3 square_to_triangle(vec2 u) {
  float su = sqrt(u.x);
  MUTATE(kMutantTriangleRootDropped, su = u.x);
  const float b0 = 1.0 - su;
  const float b1 = u.y * su;
  return vec3(b0, b1, 1.0 - b0 - b1);
}

// Direction about +Z, uniform in the cone 1 − cos θ <= one_minus_cos_max; pdf_w = 1/(2π one_minus_cos_max).
vec3 square_to_cone(vec2 u, float one_minus_cos_max) {
  float w = u.x * one_minus_cos_max;  // 1 − cos θ, exact for small angles
  MUTATE(kMutantConeTooWide, w = min(1.05 * w, 2.0));
  const float sin_theta = sqrt(max(0.0, w * (2.0 - w)));
  return vec3(sin_theta * cos_sin_turn(u.y), 1.0 - w);
}

#endif
