// The film: exact integer sums per slot, so that the order of samples never matters. The number format is derived in
// docs/conventions.md, "Film"; src/image/film.cpp is its host twin.
#ifndef FILM_GLSL
#define FILM_GLSL

#include "gpu_types.h"

// x += y + carry, limb by limb; `carry` in and out is 0 or 1.
uint add_limb(uint x, uint y, inout uint carry) {
  uint c0, c1;
  const uint s = uaddCarry(uaddCarry(x, y, c0), carry, c1);
  carry = c0 + c1;
  return s;
}

// A sample component as sign · mantissa · 2^shift film units; shift in [0, 56], mantissa < 2^24, truncated toward zero.
struct Fixed {
  uint mantissa;
  uint shift;
  bool negative;
  bool valid;  // finite and below 2^(exponent+24)
};

Fixed to_fixed(float value, int exponent) {
  const uint bits = floatBitsToUint(value);
  const uint biased = (bits >> 23u) & 0xffu;
  const uint mantissa = (bits & 0x7fffffu) | (biased > 0u ? 0x800000u : 0u);
  const int shift = int(max(biased, 1u)) - 94 - exponent;  // value = mantissa · 2^(biased − 150), unit 2^(exponent − 56)
  Fixed f;
  f.mantissa = shift >= 0 ? mantissa : (shift > -24 ? mantissa >> uint(-shift) : 0u);
  f.shift = uint(max(shift, 0));
  f.negative = (bits >> 31u) != 0u;
  f.valid = biased != 0xffu && (shift <= 56 || mantissa == 0u);
  return f;
}

uvec4 add_sum(uvec4 sum, Fixed f) {
  const uint s = f.shift & 31u;
  const uint lo = f.mantissa << s;
  const uint hi = s == 0u ? 0u : f.mantissa >> (32u - s);
  uvec4 q = f.shift < 32u ? uvec4(lo, hi, 0u, 0u) : uvec4(0u, lo, hi, 0u);
  uint carry = 0u;
  if (f.negative) {  // two's complement
    q = ~q;
    carry = 1u;
  }
  sum.x = add_limb(sum.x, q.x, carry);
  sum.y = add_limb(sum.y, q.y, carry);
  sum.z = add_limb(sum.z, q.z, carry);
  sum.w = add_limb(sum.w, q.w, carry);
  return sum;
}

// 192 bits as two triples, low limbs first.
void add_square(inout uvec3 low, inout uvec3 high, Fixed f) {
  uint msb, lsb;
  umulExtended(f.mantissa, f.mantissa, msb, lsb);
  const uint shift = 2u * f.shift;  // at most 112
  const uint s = shift & 31u;
  const uint inverse = (32u - s) & 31u;
  const uint keep = s == 0u ? 0u : 0xffffffffu;
  const uint a = lsb << s;
  const uint b = (msb << s) | ((lsb >> inverse) & keep);
  const uint c = (msb >> inverse) & keep;
  const uint limb = shift >> 5u;
  const uvec3 q_low = limb == 0u ? uvec3(a, b, c) : limb == 1u ? uvec3(0u, a, b) : limb == 2u ? uvec3(0u, 0u, a) : uvec3(0u);
  const uvec3 q_high = limb == 0u   ? uvec3(0u)
                       : limb == 1u ? uvec3(c, 0u, 0u)
                       : limb == 2u ? uvec3(b, c, 0u)
                                    : uvec3(a, b, c);
  uint carry = 0u;
  low.x = add_limb(low.x, q_low.x, carry);
  low.y = add_limb(low.y, q_low.y, carry);
  low.z = add_limb(low.z, q_low.z, carry);
  high.x = add_limb(high.x, q_high.x, carry);
  high.y = add_limb(high.y, q_high.y, carry);
  high.z = add_limb(high.z, q_high.z, carry);
}

// Adds one sample to a slot; returns false (and counts it) when it is not finite or too large for the film.
bool film_add(inout FilmSlot slot, vec3 rgb, int exponent) {
  const Fixed r = to_fixed(rgb.r, exponent);
  const Fixed g = to_fixed(rgb.g, exponent);
  const Fixed b = to_fixed(rgb.b, exponent);
  if (!(r.valid && g.valid && b.valid)) {
    ++slot.tail.w;
    return false;
  }
  slot.sum_r = add_sum(slot.sum_r, r);
  slot.sum_g = add_sum(slot.sum_g, g);
  slot.sum_b = add_sum(slot.sum_b, b);
  uvec3 low = slot.squares_a.xyz, high = uvec3(slot.squares_a.w, slot.squares_b.xy);
  add_square(low, high, r);
  slot.squares_a = uvec4(low, high.x);
  slot.squares_b.xy = high.yz;
  low = uvec3(slot.squares_b.zw, slot.squares_c.x);
  high = slot.squares_c.yzw;
  add_square(low, high, g);
  slot.squares_b.zw = low.xy;
  slot.squares_c = uvec4(low.z, high);
  low = slot.squares_d.xyz;
  high = uvec3(slot.squares_d.w, slot.tail.xy);
  add_square(low, high, b);
  slot.squares_d = uvec4(low, high.x);
  slot.tail.xy = high.yz;
  ++slot.tail.z;
  return true;
}

#endif
