// Constants and small functions that belong nowhere else. Only + - * / sqrt and comparisons are used where a decision
// depends on the result: those are the operations Vulkan devices agree on best.
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

// The angle from +x toward +y of (x, y) as a fraction of a turn, in [0,1): polynomial of [Moshier1989], error below
// 1e-7; the built-in is only accurate to 2^-11 on some devices.
float turn_of(float x, float y) {
  const float larger = max(abs(x), abs(y)), smaller = min(abs(x), abs(y));
  if (larger == 0.0) return 0.0;
  const bool steep = smaller > 0.414213562 * larger;  // tan(pi/8): then the angle is counted from pi/4
  const float r = steep ? (smaller - larger) / (smaller + larger) : smaller / larger;
  const float z = r * r;
  float angle = r + r * z * (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1);
  angle = steep ? 0.25 * kPi + angle : angle;
  angle = abs(y) > abs(x) ? 0.5 * kPi - angle : angle;
  angle = x < 0.0 ? kPi - angle : angle;
  const float turn = (y < 0.0 ? 2.0 * kPi - angle : angle) * (0.5 * kInvPi);
  return turn < 1.0 ? turn : 0.0;
}

// Quotient, below 2^22, and remainder of a / b: lavapipe divides integers lane by lane.
uvec2 divide(uint a, uint b) {
  const uint guess = uint(float(a) / float(b));
  const int rest = int(a - guess * b);
  const int more = rest < 0 ? -1 : rest >= int(b) ? 1 : 0;
  return uvec2(guess + uint(more), uint(rest - more * int(b)));
}

// Tests the bits, because drivers may assume that isnan() is never true.
bool is_finite(vec3 v) { return all(lessThan(floatBitsToUint(v) & 0x7f800000u, uvec3(0x7f800000u))); }

#endif
