// The contract of materials and the switch between them.
//
// Directions are local (+Z = shading normal), unit length, pointing away from the surface.
//   eval(wo, wi)        f · |cos θ_i| of the non-delta part, 0 where the material does not scatter
//   pdf(wo, wi)         density of sample() w.r.t. solid angle, 0 for delta lobes
//   sample(wo, u_lobe, u)  weight = eval/pdf; `pdf` is w.r.t. solid angle, for delta lobes a discrete probability; pdf 0: no sample.
// Every u is in [0,1).
#ifndef BSDF_GLSL
#define BSDF_GLSL

#include "../scene.glsl"

// A material at a point, its parameters evaluated there: all that sample, eval and pdf know of it.
struct Material {
  uint header;  // kMaterial*
  vec3 albedo;
  float int_ior;
  float ext_ior;
};

struct BsdfSample {
  vec3 wi;
  float pdf;
  vec3 weight;
  uint lobe;        // kLobe*; kLobeNone when pdf is 0
  float eta_scale;  // (n_i/n_o)² after a refraction, else 1: undoes the radiance scaling where only energy matters (roulette)
};

const BsdfSample kNoBsdfSample = BsdfSample(vec3(0.0), 0.0, vec3(0.0), kLobeNone, 1.0);

bool is_delta(uint lobe) { return lobe == kLobeDeltaReflection || lobe == kLobeDeltaTransmission; }

#include "dielectric.glsl"
#include "diffuse.glsl"
#include "mirror.glsl"

// The scene's materials, bit i for kBsdf… = i. A constant, because a SIMD machine computes all materials for all lanes: those that no
// surface has should not be there.
layout(constant_id = kConstantBsdfsUsed) const uint kBsdfsUsed = 0xffffffffu;

bool bsdf_is(Material m, uint bsdf) {
  const uint bit = 1u << bsdf;
  return (kBsdfsUsed & bit) != 0u && (kBsdfsUsed == bit || (m.header & kMaterialTypeMask) == bsdf);
}

// The flags that some material of the scene has, and those that all have: where the two agree, nobody asks the material.
layout(constant_id = kConstantMaterialFlagsSome) const uint kMaterialFlagsSome = 0xffffffffu;
layout(constant_id = kConstantMaterialFlagsAll) const uint kMaterialFlagsAll = 0u;

bool material_has(Material m, uint flag) {
  return (kMaterialFlagsSome & flag) != 0u && ((kMaterialFlagsAll & flag) != 0u || (m.header & flag) != 0u);
}

// The material of an instance, evaluated once per hit.
Material evaluate_material(Instance instance) {
  const MaterialRecord r = fetch_material(instance.material);
  return Material(r.header, r.params, r.params.x, r.params.y);
}

vec3 bsdf_eval(Material m, vec3 wo, vec3 wi) { return bsdf_is(m, kBsdfDiffuse) ? diffuse_eval(m, wo, wi) : vec3(0.0); }

float bsdf_pdf(Material m, vec3 wo, vec3 wi) { return bsdf_is(m, kBsdfDiffuse) ? diffuse_pdf(wo, wi) : 0.0; }

BsdfSample bsdf_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  if (bsdf_is(m, kBsdfDiffuse)) return diffuse_sample(m, wo, u);
  if (bsdf_is(m, kBsdfMirror)) return mirror_sample(wo);
  if (bsdf_is(m, kBsdfDielectric)) return dielectric_sample(m, wo, u_lobe);
  return kNoBsdfSample;
}

#endif
