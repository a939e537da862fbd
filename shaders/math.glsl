// Constants and small functions without a home elsewhere. Only + - * / sqrt and comparisons are used where a decision depends on
// the result: those are the operations Vulkan devices agree on best.
#ifndef MATH_GLSL
#define MATH_GLSL

const float kPi = 3.14159265358979;
const float kInvPi = 0.318309886183791;
const float kInfinity = 1.0 / 0.0;

float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }

// Rec. 709 luminance with the weights of the scene format.
float luminance(vec3 rgb) { return dot(rgb, vec3(0.212671, 0.715160, 0.072169)); }

// (cos x, sin x) for |x| <= pi/4: polynomials of [Moshier1989], error below 1e-7. The built-ins are only accurate to 2^-11 on some
// devices, which would show as a different picture.
vec2 cos_sin_octant(float x) {
  const float x2 = x * x;
  const float c = 1.0 - 0.5 * x2 + x2 * x2 * (4.166664568298827e-2 + x2 * (-1.388731625493765e-3 + x2 * 2.443315711809948e-5));
  const float s = x + x * x2 * (-1.6666654611e-1 + x2 * (8.3321608736e-3 + x2 * -1.9515295891e-4));
  return vec2(c, s);
}

// (cos 2πu, sin 2πu) for u in [0,1).
vec2 cos_sin_turn(float u) {
  const float quadrant = floor(4.0 * u + 0.5);
  const vec2 cs = cos_sin_octant((u - 0.25 * quadrant) * (2.0 * kPi));
  const uint q = uint(quadrant) & 3u;
  const vec2 turned = (q & 1u) != 0u ? vec2(-cs.y, cs.x) : cs;
  return (q & 2u) != 0u ? -turned : turned;
}

// By the bits: drivers may assume that isnan() is never true.
bool is_finite(vec3 v) { return all(lessThan(floatBitsToUint(v) & 0x7f800000u, uvec3(0x7f800000u))); }

#endif
