// Random numbers as a pure function of (seed, pixel, sample, block); see docs/conventions.md, "Random numbers".
#ifndef SAMPLER_GLSL
#define SAMPLER_GLSL

#include "mutants.h"

const uint kBlockCamera = 0u;
// Blocks of surface vertex k = 0, 1, …
uint block_light(uint k) { return 1u + 2u * k; }
uint block_bsdf(uint k) {
  MUTATE(kMutantDimensionReused, k = 0u);
  return 2u + 2u * k;
}

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

uvec4 random_words(uint seed, uint pixel, uint sample_index, uint block) {
  MUTATE(kMutantSampleIndexIgnored, sample_index = 0u);
  MUTATE(kMutantNumbersEqual, return pcg4d(uvec4(pixel, sample_index, block, seed)).xyyy);
  return pcg4d(uvec4(pixel, sample_index, block, seed));
}

// [0,1) from the top 24 bits: 1 is never returned.
float to_unit(uint word) { return float(word >> 8u) * (1.0 / 16777216.0); }
vec2 to_unit(uvec2 words) { return vec2(words >> 8u) * (1.0 / 16777216.0); }

#endif
