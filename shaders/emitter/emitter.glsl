// Choosing a light and sampling a point on it; what emission by chance would have been sampled with.
#ifndef EMITTER_GLSL
#define EMITTER_GLSL

#include "../sampler.glsl"
#include "../surface.glsl"
#include "../warp.glsl"

struct LightSample {
  vec3 p;
  float error;    // of p, see surface_error
  vec3 ng;
  float pdf_w;    // w.r.t. solid angle at the receiver, choice probabilities included; 0: no light
  vec3 wi;        // unit, receiver to light
  float mis_pdf;  // the density the multiple-importance weight uses (docs/conventions.md, "Emitters")
  vec3 radiance;
  uint shape;
  uint primitive;
};

layout(constant_id = kConstantSphereLights) const bool kSphereLights = true;

#include "area.glsl"

// Rounds of the bisections below: ceil(log2) of the number of emitting shapes, and of the primitives of the one with most. As constants, because
// an exit test would not save the lanes of a SIMD group anything.
layout(constant_id = kConstantLightShapeRounds) const uint kLightShapeRounds = 32u;
layout(constant_id = kConstantLightPrimitiveRounds) const uint kLightPrimitiveRounds = 32u;

// Last entry whose threshold is <= word, by bisection: integers, so every device chooses alike. Further rounds change nothing.
uint choose_light_shape(uint word) {
  uint first = 0u, count = frame.light_shape_count;
  for (uint i = 0u; i < kLightShapeRounds; ++i) {
    const uint half_count = count >> 1u;
    const bool upper = fetch_light_shape(first + half_count).threshold <= word;
    first = upper ? first + half_count : first;
    count = upper ? count - half_count : half_count;
  }
  return first;
}

uint choose_light_primitive(LightShape light, uint word) {
  uint first = light.first_primitive, count = light.primitive_count;
  for (uint i = 0u; i < kLightPrimitiveRounds; ++i) {
    const uint half_count = count >> 1u;
    const bool upper = fetch_light_primitive(first + half_count).threshold <= word;
    first = upper ? first + half_count : first;
    count = upper ? count - half_count : half_count;
  }
  return first;
}

#include "light_tree.glsl"

LightSample sample_light_of_tree(vec3 p, vec3 n, uvec4 words) {
  float prob;
  const uint slot = choose_light(p, n, words.xy, prob);
  const uint shape_index = fetch_primitive(slot).shape;
  // The primitive as the only one of its shape, chosen with probability `prob`: so the tree's choices look to area.glsl.
  Shape shape = fetch_shape(shape_index);
  shape.light_prob = prob;
  LightSample ls = area_sample(p, shape_index, shape, LightPrimitive(0u, slot, 1.0, 0u), to_unit(words.zw));
  ls.mis_pdf = ls.pdf_w;
  ls.shape = prob > 0.0 ? ls.shape : kNone;
  return ls;
}

// For a surface at p with shading normal n: words.xy choose the primitive (words.x its shape, where lights are chosen by power), words.zw the point.
// `shape` is kNone when no light can contribute.
LightSample sample_light(vec3 p, vec3 n, uvec4 words) {
  if (kLightTree) return sample_light_of_tree(p, n, words);
  const LightShape light = fetch_light_shape(choose_light_shape(words.x));
  const LightPrimitive choice = fetch_light_primitive(choose_light_primitive(light, words.y));
  return area_sample(p, light.shape, fetch_shape(light.shape), choice, to_unit(words.zw));
}

// Density with which sample_light would have found the surface point `s` from `p` in direction wi; the mis_pdf of LightSample.
float light_pdf(vec3 p, vec3 n, vec3 wi, Surface s, Shape shape, uint slot) {
  if (kLightTree) {
    // No walk for what does not emit: the loop ends at once when that holds for all lanes.
    const LightTrail trail = shape.light_prob > 0.0 ? fetch_light_trail(s.shape, s.primitive) : LightTrail(0u, 1.0, 0u, 0u);
    shape.light_prob = light_choice_prob(p, n, trail.turns);
    shape.light_area = trail.area;
  }
  MUTATE(kMutantMisChoiceForgotten, return area_pdf(p, wi, s, shape, slot) / shape.light_prob);
  return area_pdf(p, wi, s, shape, slot);
}

#endif
