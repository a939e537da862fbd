// What scatters at a surface: a material in its frame, or a mixture of two; docs/conventions.md, "Adapters".
#ifndef SCATTERER_GLSL
#define SCATTERER_GLSL

#include "adapters.glsl"
#include "bsdf/bsdf.glsl"
#include "mutants.h"
#include "surface.glsl"

// A material, the surface in its frame, and the direction toward which it scatters.
struct Scatterer {
  Surface s;
  Material material;
  vec3 wo;
};

// The other half of a mixture: a blend chose one of the two with a probability equal to its share, and the mixture reflects `share f₁ + (1 − share)
// f₂`, whichever was chosen.
struct OtherHalf {
  Scatterer scatterer;
  float share;  // of the chosen half; below 0 if there is no other half
};
#define is_mixed(other) (kBlended && (other).share >= 0.0)

// If a map has turned the normal, directions on different sides of it and of the normal before carry no light, ...
bool sides_agree(Surface s, vec3 w, float cosine) {
  MUTATE(kMutantMapsShineThrough, return true);
  return !kPerturbed || dot(w, s.base) * cosine > 0.0;
}

// ... and the others are shadowed like microfacets as steep as the turned normal [Conty2019].
float turned_share(Surface s, vec3 w) {
  if (!kPerturbed || (kLooseMaps && !s.shadowed)) return 1.0;
  const float turn = dot(s.base, s.frame.n), across = dot(s.base, w);
  const float slope2 = max(0.0, 1.0 - turn * turn) / (turn * turn), tan2 = max(0.0, 1.0 - across * across) / (across * across);
  return 2.0 / (1.0 + sqrt(1.0 + min(0.125 * slope2, 1.0) * tan2));
}

// Toward w in the world. Directions that carry no light still have their density.
Scattering scattering(Scatterer m, vec3 w) {
  const vec3 wi = to_local(m.s.frame, w);
  Scattering s = bsdf_evaluate(m.material, m.wo, wi);
  s.value = sides_agree(m.s, w, wi.z) ? s.value * turned_share(m.s, w) : vec3(0.0);
  return s;
}

// For a mixture, one number for each half.
float mixed(OtherHalf other, float a, float b) { return other.share * a + (1.0 - other.share) * b; }
vec3 mixed(OtherHalf other, vec3 a, vec3 b) { return other.share * a + (1.0 - other.share) * b; }

// The material chosen at a surface, and the part of it seen from w.
Scatterer scatterer_of(Choice choice, Surface s, SurfacePoint at, Primitive geometry, vec3 w) {
  Material material = evaluate_material(choice.material, at);
  s.frame = choice.frame;
  s.base = choice.base;
  s.shadowed = choice.shadowed;
  if (textures_have(kTexturesTangents) && material_has(material, kMaterialAligned)) s.frame = aligned_frame(s.frame.n, at, geometry);
  if (kCoatNormals && material_has(material, kMaterialCoatNormal)) material.coat = to_local(s.frame, coat_normal(choice, at, geometry, w));
  return Scatterer(s, material, to_local(s.frame, w));
}

// Whether nothing scatters toward w.
bool is_black(Scatterer m, vec3 w) {
  return (material_has(m.material, kMaterialOneSided) && m.wo.z <= 0.0) || !sides_agree(m.s, w, m.wo.z);
}

bool absorbs_behind(Material m) { return kVolumes && material_has(m, kMaterialVolume) && material_has(m, kMaterialTransmissive); }

// The half that a blend has not chosen, for a mixture. There is none if it lets the ray pass or is black, or if light is absorbed behind either half.
OtherHalf other_half(Scatterer chosen, OtherChoice choice, SurfacePoint at, Primitive geometry, vec3 w, uvec4 words) {
  OtherChoice nested = choice;
  go_to_material(choice.choice, nested, at, geometry, w, words);
  const bool passes = choice.choice.material == kNone;
  if (passes) choice.choice.material = 0u;
  const Scatterer other = scatterer_of(choice.choice, chosen.s, at, geometry, w);
  return OtherHalf(other, passes || absorbs_behind(chosen.material) || absorbs_behind(other.material) || is_black(other, w) ? -1.0 : choice.share);
}

// A direction sampled by the chosen half, with the density and the weight of the mixture; wi is in the world.
BsdfSample sample_scattering(Scatterer chosen, OtherHalf other, float u_lobe, vec2 u, out vec3 wi) {
  BsdfSample bs = bsdf_sample(chosen.material, chosen.wo, u_lobe, u);
  wi = to_world(chosen.s.frame, bs.wi);
  bs.weight *= sides_agree(chosen.s, wi, bs.wi.z) ? turned_share(chosen.s, wi) : 0.0;
  if (is_mixed(other) && bs.pdf > 0.0 && !is_delta(bs.lobe)) {
    const Scattering its = scattering(other.scatterer, wi);
    float pdf = mixed(other, bs.pdf, its.pdf);
    MUTATE(kMutantMixtureHalfDense, pdf = bs.pdf);
    bs.weight = mixed(other, bs.pdf * bs.weight, its.value) / pdf;
    bs.pdf = pdf;
  }
  return bs;
}

#endif
