// What stands between a surface and the materials that scatter there; docs/conventions.md, "Adapters".
#ifndef ADAPTERS_GLSL
#define ADAPTERS_GLSL

#include "frame.glsl"
#include "material_flags.glsl"
#include "mutants.h"
#include "sampler.glsl"
#include "scene.glsl"
#include "texture.glsl"

layout(constant_id = kConstantAdapterDepth) const uint kAdapterDepth = 0u;  // how many stand one in the other
layout(constant_id = kConstantCountPasses) const bool kCountPasses = true;  // a segment ends at a surface that it passes

bool adapter_is(uint header, uint type) { return (kAdapters >> (type - kAdapterFirst) & 1u) != 0u && (header & kMaterialTypeMask) == type; }

// A material that was chosen, and the frame in which it sees directions.
struct Choice {
  uint material;  // kNone: light passes the surface
  ShadingFrame frame;
};

// The probability that an adapter has at a point.
float adapter_number(uint row, MaterialRecord record, SurfacePoint at) {
  if (!kTextured || (record.header & kMaterialTextured) == 0u) return record.params.z;
  return record.params.z * scalar_factor(fetch_material_textures(row).first.x, at);
}

// `w` points away from the surface, to the side that is looked at; `words` are those of choice_words().
Choice choose_material(uint row, ShadingFrame frame, SurfacePoint at, vec3 w, uvec4 words) {
  Choice choice = Choice(row, frame);
  for (uint i = 0u; i <= kAdapterDepth; ++i) {
    const MaterialRecord record = fetch_material(choice.material, false);
    const uint first = uint(record.params.x), second = uint(record.params.y);
    uint next = kNone;
    if (adapter_is(record.header, kAdapterTwoSided)) {
      const bool behind = dot(w, choice.frame.n) < 0.0;
      next = behind ? second : first;
      MUTATE(kMutantSidesSwapped, next = behind ? first : second);
      if (behind) choice.frame.n = -choice.frame.n;
    }
    if (adapter_is(record.header, kAdapterMask) || adapter_is(record.header, kAdapterBlend)) {
      const bool blend = adapter_is(record.header, kAdapterBlend);
      const bool chosen = choice_number(words, choice.material) < adapter_number(choice.material, record, at);
      next = blend ? (chosen ? second : first) : (chosen ? first : kNone);
      MUTATE(kMutantBlendSwapped, next = blend ? (chosen ? first : second) : next);
    }
    const uint type = record.header & kMaterialTypeMask;
    if (type < kAdapterFirst) {
      if (kPassable && type == kBsdfNull) choice.material = kNone;
      break;
    }
    choice.material = next;
    if (next == kNone) break;
  }
  return choice;
}

#endif
