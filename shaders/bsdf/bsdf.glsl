// The contract of materials and the switch between them.
//
// Directions are local (+Z = shading normal), unit length, pointing away from the surface.
//   eval(wo, wi)        f · |cos θ_i| of the non-delta part, 0 where the material does not scatter
//   pdf(wo, wi)         density of sample() w.r.t. solid angle, 0 for delta lobes
//   sample(wo, u_lobe, u)  weight = eval/pdf; `pdf` is w.r.t. solid angle, for delta lobes a discrete probability; pdf 0: no sample.
// Every u is in [0,1).
#ifndef BSDF_GLSL
#define BSDF_GLSL

#include "../gpu_types.h"

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

bool bsdf_is(Shape m, uint bsdf) {
  const uint bit = 1u << bsdf;
  return (kBsdfsUsed & bit) != 0u && (kBsdfsUsed == bit || m.bsdf == bsdf);
}

// True when the material has only delta lobes, so that light sampling cannot contribute.
bool bsdf_is_delta(Shape m) { return !bsdf_is(m, kBsdfDiffuse); }

// True when the material is black seen from behind.
bool bsdf_is_one_sided(Shape m) { return !bsdf_is(m, kBsdfDielectric); }

vec3 bsdf_eval(Shape m, vec3 wo, vec3 wi) { return bsdf_is(m, kBsdfDiffuse) ? diffuse_eval(m, wo, wi) : vec3(0.0); }

float bsdf_pdf(Shape m, vec3 wo, vec3 wi) { return bsdf_is(m, kBsdfDiffuse) ? diffuse_pdf(wo, wi) : 0.0; }

BsdfSample bsdf_sample(Shape m, vec3 wo, float u_lobe, vec2 u) {
  if (bsdf_is(m, kBsdfDiffuse)) return diffuse_sample(m, wo, u);
  if (bsdf_is(m, kBsdfMirror)) return mirror_sample(wo);
  if (bsdf_is(m, kBsdfDielectric)) return dielectric_sample(m, wo, u_lobe);
  return kNoBsdfSample;
}

#endif
