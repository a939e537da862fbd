// Choosing a light and sampling a point on it, and the density with which a light hit by chance would have been sampled.
#ifndef EMITTER_GLSL
#define EMITTER_GLSL

#include "../features.glsl"
#include "../sampler.glsl"
#include "../surface.glsl"
#include "../texture.glsl"
#include "../warp.glsl"

// A cell of the environment and the position within it, both coordinates from 0 to 1.
struct EnvironmentPlace {
  uint column;
  uint row;
  float across;
  float down;
};

struct LightSample {
  vec3 p;
  float error;    // of p, see surface_error
  vec3 ng;
  float pdf_w;    // w.r.t. solid angle at the receiver, choice probabilities included; 0: no light
  vec3 wi;        // unit, receiver to light
  float mis_pdf;  // the density the multiple-importance weight uses (docs/conventions.md, "Emitters")
  vec3 radiance;
  uint instance;
  uint primitive;
  EnvironmentPlace sky;  // of the environment; its picture is still to be looked at, see LookUp
};

layout(constant_id = kConstantSphereLights) const bool kSphereLights = true;
FEATURE(bool, kCylinderLights, kConstantCylinderLights, false)
FEATURE(bool, kLampParts, kConstantLampParts, false)
layout(constant_id = kConstantLightNormals) const bool kLightNormals = true;  // some light has vertex normals

#include "area.glsl"
#include "delta.glsl"

// Number of rounds of the bisections below: ceil(log2) of the number of emitting instances, and of the largest number of primitives in one.
// Constants, because an exit test would not save the lanes of a SIMD group anything.
layout(constant_id = kConstantLightInstanceRounds) const uint kLightInstanceRounds = 32u;
layout(constant_id = kConstantLightPrimitiveRounds) const uint kLightPrimitiveRounds = 32u;

// Last entry whose threshold is <= word, by bisection: integers, so every device makes the same choice. Additional rounds change nothing.
uint choose_light_instance(uint word) {
  uint first = 0u, count = frame.light_instance_count;
  for (uint i = 0u; i < kLightInstanceRounds; ++i) {
    const uint half_count = count >> 1u;
    const bool upper = fetch_light_instance(first + half_count).threshold <= word;
    first = upper ? first + half_count : first;
    count = upper ? count - half_count : half_count;
  }
  return first;
}

uint choose_light_primitive(LightInstance light, uint word) {
  uint first = light.first_primitive, count = light.primitive_count;
  for (uint i = 0u; i < kLightPrimitiveRounds; ++i) {
    const uint half_count = count >> 1u;
    const bool upper = fetch_light_primitive_threshold(first + half_count) <= word;
    first = upper ? first + half_count : first;
    count = upper ? count - half_count : half_count;
  }
  return first;
}

#include "lamp_parts.glsl"
#include "light_tree.glsl"
#include "shared_light.glsl"
#include "environment.glsl"

LightSample sample_light_of_tree(vec3 p, vec3 n, uvec4 words) {
  float prob;
  const uint leaf = choose_light(p, n, words.xy, prob);
  if (kInstanced) {
    if ((leaf & kLightLeafShared) != 0u) {
      const LightInstance light = fetch_light_instance(leaf & ~kLightLeafShared);
      LightSample ls = sample_shared_light(p, light, prob, light_word(kTriangleLevel, words.y), to_unit(words.zw));
      ls.instance = prob > 0.0 ? ls.instance : kNone;
      return ls;
    }
  }
  if (kDeltaLights != 0u) {
    if ((leaf & kLightLeafDelta) != 0u) {
      LightSample ls = sample_delta_light(p, fetch_delta_light(leaf & ~kLightLeafDelta), prob);
      ls.instance = prob > 0.0 ? ls.instance : kNone;
      return ls;
    }
  }
  const LightPrimitive light = fetch_light_primitive(leaf);
  const Primitive prim = light.primitive;
  // The tree chooses primitives, each as the only one of its instance.
  LightSample ls = area_sample(p, prim, fetch_instance(prim.instance), LightChoice(prob, part_density(light), 1.0), part_point(light, to_unit(words.zw)));
  ls.mis_pdf = ls.pdf_w;
  ls.instance = prob > 0.0 ? ls.instance : kNone;
  return ls;
}

// For a surface at p with shading normal n: words.xy choose the primitive (words.x its instance, where lights are chosen by power), words.zw the point.
// `instance` is kNone when no light can contribute.
LightSample sample_light(vec3 p, vec3 n, uvec4 words) {
  if (kLightTree) return sample_light_of_tree(p, n, words);
  const LightInstance light = fetch_light_instance(choose_light_instance(words.x));
  if (kDeltaLights != 0u) {
    if ((light.instance & kLightLeafDelta) != 0u) {
      const DeltaLight delta = fetch_delta_light(light.instance & ~kLightLeafDelta);
      return sample_delta_light(p, delta, delta.prob);
    }
  }
  if (kInstanced) {
    const Instance owner = fetch_instance(light.instance);
    if (owner.place != kNone) return sample_shared_light(p, light, owner.light_prob, words.y, to_unit(words.zw));
  }
  const LightPrimitive choice = fetch_light_primitive(choose_light_primitive(light, words.y));
  const Instance instance = fetch_instance(light.instance);
  const LightChoice how = LightChoice(instance.light_prob, choice.prob * part_density(choice), light_area_of(instance));
  LightSample ls = area_sample(p, choice.primitive, instance, how, part_point(choice, to_unit(words.zw)));
  if (kLampParts && choice.cells > 0u) ls.mis_pdf = ls.pdf_w;
  return ls;
}

// Density with which sample_light would have found the surface point `s` from `p` in direction wi; the mis_pdf of LightSample. `weights` are those of
// the vertices of a triangle.
float light_pdf(vec3 p, vec3 n, vec3 wi, Surface s, vec3 weights, Instance instance, Primitive prim) {
  float prob = instance.light_prob;
  float area = light_area_of(instance);
  if (kLightTree) {
    // No walk for surfaces that do not emit: the loop ends at once if this is true for all lanes.
    LightTrail trail = LightTrail(0u, 1.0, 0u, 0u);
    if (instance.light_prob > 0.0) trail = light_trail(fetch_first_trail(s.instance), kInstanced && instance.place != kNone ? 0u : s.primitive, weights);
    prob = light_choice_prob(p, n, trail.turns);
    area = trail.area;
  } else if (kLampParts) {
    const uint first = fetch_first_trail(s.instance);
    if (first != 0u) area = light_trail(first, s.primitive, weights).area;
  }
  if (kInstanced && instance.place != kNone) area *= place_area_factor(fetch_place(instance.place), s.ng);
  MUTATE(kMutantMisChoiceForgotten, return area_pdf(p, wi, s, prim, prob, area) / prob);
  return area_pdf(p, wi, s, prim, prob, area);
}

// Factor of all densities of lights: the environment is chosen before them.
float lights_prob() {
  MUTATE(kMutantLightsShareForgotten, return 1.0);
  return kHasOutside ? frame.lights_prob : 1.0;
}

#endif
