// Random numbers as a pure function of (seed, pixel, path, block); see docs/conventions.md, "Random numbers" and "Sobol sets".
#ifndef SAMPLER_GLSL
#define SAMPLER_GLSL

#include "mutants.h"

// 0: independent numbers. Else paths come in sets of 2^kSetBits whose numbers are one scrambled Sobol net each. A constant, because
// lavapipe would compute both kinds of numbers behind an `if`.
layout(constant_id = kConstantSetBits) const uint kSetBits = 0u;
const uint kMaxSetBits = 12u;

const uint kBlockCamera = 0u;
const uint kBlockLens = 0x81000000u;
// Blocks of surface vertex k = 0, 1, …
uint block_light(uint k) { return 1u + 2u * k; }
uint block_bsdf(uint k) {
  MUTATE(kMutantDimensionReused, k = 0u);
  return 2u + 2u * k;
}

// The block for sampling the environment, one of the reserved blocks.
uint block_environment(uint k) { return 0x83000000u + (k & 0xffffffu); }

// Four-in, four-out integer hash [Jarzynski2020].
uvec4 pcg4d(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v ^= v >> 16u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// The decision of an adapter at vertex k is a hash of what is hit there, independent of other hits on the way; docs/conventions.md, "Adapters".
// `flags` has 1 for the side behind the geometric normal, 2 for a shadow ray that began at the vertex.
uvec4 choice_words(uint seed, uint pixel, uint path, uint k, uint instance, uint primitive, uint flags) {
  MUTATE(kMutantSampleIndexIgnored, path = 0u);
  return pcg4d(uvec4(pixel, path, 0x82000000u + (k & 0xffffffu), seed)) + uvec4(instance, primitive, flags, 0u);
}

// Nested uniform scrambling of words whose most significant digit is bit 0: bit n changes by a hash of the bits below it and of the
// seed [Burley2020], constants of [Vegdahl2021].
uint owen_hash(uint x, uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16u) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Columns of the generator matrices of Sobol dimensions 2, 3 and 4 [Joe2008], bit-reversed: bit 0 is the first binary digit. That of dimension 1
// is 1 << column.
const uvec3 kSobolColumns[kMaxSetBits] = uvec3[](
    uvec3(0x1u, 0x1u, 0x1u), uvec3(0x3u, 0x3u, 0x3u), uvec3(0x5u, 0x6u, 0x4u), uvec3(0xfu, 0x9u, 0xau), uvec3(0x11u, 0x17u, 0x1fu),
    uvec3(0x33u, 0x3au, 0x2eu), uvec3(0x55u, 0x71u, 0x45u), uvec3(0xffu, 0xa3u, 0xc9u), uvec3(0x101u, 0x116u, 0x11bu),
    uvec3(0x303u, 0x339u, 0x2a4u), uvec3(0x505u, 0x677u, 0x79au), uvec3(0xf0fu, 0x9aau, 0xb67u));

// The four words of one path of a set: a point of the 4D Sobol sequence, taken in this block's own order and
// Owen-scrambled.
uvec4 sobol_point(uint seed, uint pixel, uint path, uint block) {
  const uvec4 h = pcg4d(uvec4(pixel, path >> kSetBits, block, seed));
  // The set in this block's own order: scrambled starting at the last binary digit, then at the first. Only one of the
  // two would keep pairs of paths together in all blocks. Only the lowest kSetBits bits count; afterwards the most
  // significant comes first.
  const uint place = owen_hash(bitfieldReverse(owen_hash(path, h.x ^ h.y)) >> (32u - kSetBits), h.z ^ h.w);
  uvec4 point = uvec4(0u);
  for (uint i = 0u; i < kSetBits; ++i) {
    const uint column = kSetBits - 1u - i;
    point ^= uvec4(1u << column, kSobolColumns[column]) & -((place >> i) & 1u);
  }
  MUTATE(kMutantDimensionsPaired, return bitfieldReverse(uvec4(owen_hash(point.x, h.x))));
  MUTATE(kMutantScramblingMissing, return bitfieldReverse(point));
  return bitfieldReverse(uvec4(owen_hash(point.x, h.x), owen_hash(point.y, h.y), owen_hash(point.z, h.z), owen_hash(point.w, h.w)));
}

uvec4 sobol_words(uint seed, uint pixel, uint path, uint block) {
  const uvec4 point = sobol_point(seed, pixel, path, block);
  // Dimensions 1 and 2 are used where two numbers give a point on the film, on a light, or a direction.
  return block == kBlockCamera ? point : (block & 1u) != 0u ? point.zwxy : point.zxyw;
}

uvec4 random_words(uint seed, uint pixel, uint path, uint block) {
  MUTATE(kMutantSampleIndexIgnored, path = 0u);
  if (kSetBits > 0u) return sobol_words(seed, pixel, path, block);
  MUTATE(kMutantNumbersEqual, return pcg4d(uvec4(pixel, path, block, seed)).xyyy);
  return pcg4d(uvec4(pixel, path, block, seed));
}

// For a reserved block: the dimensions of a point in their natural order.
uvec4 reserved_words(uint seed, uint pixel, uint path, uint block) {
  MUTATE(kMutantSampleIndexIgnored, path = 0u);
  if (kSetBits > 0u) return sobol_point(seed, pixel, path, block);
  return pcg4d(uvec4(pixel, path, block, seed));
}

// [0,1) from the top 24 bits: 1 is never returned.
float to_unit(uint word) { return float(word >> 8u) * (1.0 / 16777216.0); }
// The random number of the adapter in one row of the materials.
float choice_number(uvec4 words, uint row) { return to_unit(pcg4d(words + uvec4(0u, 0u, 0u, row)).x); }
vec2 to_unit(uvec2 words) { return vec2(words >> 8u) * (1.0 / 16777216.0); }

#endif
