// The contract of materials and the switch between them.
//
// Directions are local (+Z = shading normal), unit length, pointing away from the surface.
//   eval(wo, wi)        f · |cos θ_i| of the non-delta part, 0 where the material does not scatter
//   pdf(wo, wi)         density of sample() w.r.t. solid angle, 0 for delta lobes
//   sample(wo, u_lobe, u)  weight = eval/pdf; `pdf` is w.r.t. solid angle, for delta lobes a discrete probability; pdf 0: no sample.
// Every u is in [0,1).
#ifndef BSDF_GLSL
#define BSDF_GLSL

#include "../adapters.glsl"
#include "../features.glsl"
#include "../material_flags.glsl"
#include "../microfacets.glsl"
#include "../scene.glsl"
#include "../texture.glsl"

// A material at a point, its parameters evaluated there: all that sample, eval and pdf know of it.
struct Material {
  uint header;  // kMaterial*
  vec3 albedo;
  float int_ior;
  float ext_ior;
  vec2 alpha;     // of microfacets
  vec3 specular;  // specular reflectance
  float share;    // of samples that go to microfacets, the others go to the diffuse base
  vec3 eta;       // complex index of refraction of a metal
  vec3 k;         // see MaterialRecord
};

const float kLeastRoughness = 1e-3;  // etendue::kMinRoughness

struct BsdfSample {
  vec3 wi;
  float pdf;
  vec3 weight;
  uint lobe;        // kLobe*; kLobeNone when pdf is 0
  float eta_scale;  // (n_i/n_o)² after a refraction, else 1: undoes the radiance scaling where only energy matters (roulette)
};

const BsdfSample kNoBsdfSample = BsdfSample(vec3(0.0), 0.0, vec3(0.0), kLobeNone, 1.0);

bool is_delta(uint lobe) { return lobe == kLobeDeltaReflection || lobe == kLobeDeltaTransmission; }

// The scene's materials, bit i for kBsdf… = i. A constant, because a SIMD machine computes all materials for all lanes: those that no
// surface has should not be there.
layout(constant_id = kConstantBsdfsUsed) const uint kBsdfsUsed = 0xffffffffu;

// What is not built is known here already, not in the function.
#define bsdf_is(m, bsdf) ((kBsdfsBuilt & 1u << (bsdf)) != 0u && has_bsdf(m, bsdf))
#define bsdf_among(m, types) ((kBsdfsBuilt & (types)) != 0u && has_bsdf_among(m, types))

bool has_bsdf(Material m, uint bsdf) {
  const uint bit = 1u << bsdf;
  return (kBsdfsUsed & bit) != 0u && (kBsdfsUsed == bit || (m.header & kMaterialTypeMask) == bsdf);
}

bool material_has(Material m, uint flag) {
  return (kMaterialFlagsSome & flag) != 0u && ((kMaterialFlagsAll & flag) != 0u || (m.header & flag) != 0u);
}

#include "conductor.glsl"
#include "dielectric.glsl"
#include "diffuse.glsl"
#include "microfacet.glsl"
#include "mirror.glsl"
#include "null.glsl"
#include "plastic.glsl"
#include "roughconductor.glsl"
#include "roughdielectric.glsl"
#include "roughplastic.glsl"
#include "thindielectric.glsl"

// Types of more parameters than a first texel holds, and among them those of microfacets.
const uint kRoughTypes = 1u << kBsdfMicrofacet | 1u << kBsdfRoughConductor | 1u << kBsdfRoughDielectric | 1u << kBsdfRoughPlastic;
const uint kRichTypes = 1u << kBsdfPrincipled | kRoughTypes | 1u << kBsdfConductor | 1u << kBsdfThinDielectric | 1u << kBsdfPlastic;

bool has_bsdf_among(Material m, uint types) {
  return (kBsdfsUsed & types) != 0u && ((kBsdfsUsed & ~types) == 0u || (types >> (m.header & kMaterialTypeMask) & 1u) != 0u);
}

#include "../rough_surface.glsl"
#include "principled.glsl"

// One without parameters beyond the first texel.
Material plain_material(uint header, vec3 params) {
  return Material(header, params, params.x, params.y, vec2(1.0), vec3(0.0), 0.0, vec3(1.0), vec3(0.0));
}

// A metal keeps its index in eta and k, a dielectric its two where a metal has the first components of them.
Material rich_material(MaterialRecord r) {
  return Material(r.header, r.params, r.eta.x, r.eta.y, vec2(r.alpha_u, r.alpha_v), r.specular, r.share, r.eta, r.k);
}

// A material without its textures.
Material stored_material(uint row) {
  if ((kBsdfsBuilt & kRichTypes) == 0u || (kBsdfsUsed != 0u && (kBsdfsUsed & kRichTypes) == 0u)) {
    const MaterialRecord r = fetch_material(row, false);
    return plain_material(r.header, r.params);
  }
  const MaterialRecord r = fetch_material(row, true);
  Material m = rich_material(r);
  if (!bsdf_among(m, kRichTypes)) m = plain_material(r.header, r.params);
  return m;
}

void apply_principled_textures(inout Material m, MaterialTextures textures, SurfacePoint at) {
  m.albedo = clamp(m.albedo, 0.0, 1.0);
  if (!textures_have(kTexturesRich)) return;
  m.eta.y = clamp(m.eta.y * scalar_factor(textures.first.y, at), 0.0, 1.0);
  m.specular.x = clamp(m.specular.x * scalar_factor(textures.first.z, at), 0.0, 1.0);
  m.share = clamp(m.share * scalar_factor(textures.first.w, at), 0.0, 1.0);
  m.specular.y = clamp(m.specular.y * scalar_factor(textures.second.x, at), 0.0, 1.0);
  m.specular.z = clamp(m.specular.z * scalar_factor(textures.second.y, at), 0.0, 1.0);
  m.k.x = clamp(m.k.x * scalar_factor(textures.second.z, at), 0.0, 1.0);
  m.k.z = clamp(m.k.z * scalar_factor(textures.second.w, at), 0.0, 1.0);
}

// What its textures make of a material; reflectances and roughness stay in the range that constants have.
void apply_rich_textures(inout Material m, uvec4 textures, SurfacePoint at) {
  m.albedo = clamp(m.albedo, 0.0, 1.0);
  if (textures_have(kTexturesRich)) {
    m.specular = clamp(m.specular * color_factor(textures.y, at), 0.0, 1.0);
    m.alpha = clamp(m.alpha * vec2(scalar_factor(textures.z, at), scalar_factor(textures.w, at)), kLeastRoughness, 1.0);
  }
  if (bsdf_is(m, kBsdfMicrofacet)) {
    m.share = 1.0 - max_component(m.albedo);
    m.specular = vec3(m.share);
  }
  if (bsdf_is(m, kBsdfPlastic) || bsdf_is(m, kBsdfRoughPlastic)) {
    const float coat = dot(m.specular, vec3(1.0)), base = dot(m.albedo, vec3(1.0));
    m.share = coat + base > 0.0 ? coat / (coat + base) : 1.0;
  }
}

// A material at a point, evaluated once per hit.
Material evaluate_material(uint row, SurfacePoint at) {
  Material m = stored_material(row);
  if (kTextured && material_has(m, kMaterialTextured)) {
    const uvec4 textures = fetch_material_textures(row).first;
    m.albedo *= color_factor(textures.x, at);
    if (bsdf_is(m, kBsdfPrincipled)) {
      apply_principled_textures(m, fetch_material_textures(row), at);
    } else if (bsdf_among(m, kRichTypes)) {
      apply_rich_textures(m, textures, at);
    }
  }
  if (bsdf_is(m, kBsdfPrincipled)) resolve_principled(m);
  return m;
}

vec3 bsdf_eval(Material m, vec3 wo, vec3 wi) {
  vec3 value = vec3(0.0);
  if (bsdf_is(m, kBsdfDiffuse)) value = diffuse_eval(m, wo, wi);
  if (bsdf_is(m, kBsdfPlastic)) value = plastic_eval(m, wo, wi);
  if (bsdf_among(m, kRoughTypes)) value = rough_evaluate(m, wo, wi).value;
  if (bsdf_is(m, kBsdfPrincipled)) value = principled_evaluate(m, wo, wi).value;
  return value;
}

float bsdf_pdf(Material m, vec3 wo, vec3 wi) {
  float pdf = 0.0;
  if (bsdf_is(m, kBsdfDiffuse)) pdf = diffuse_pdf(wo, wi);
  if (bsdf_is(m, kBsdfPlastic)) pdf = plastic_pdf(m, wo, wi);
  if (bsdf_among(m, kRoughTypes)) pdf = rough_evaluate(m, wo, wi).pdf;
  if (bsdf_is(m, kBsdfPrincipled)) pdf = principled_evaluate(m, wo, wi).pdf;
  return pdf;
}

BsdfSample bsdf_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  if (bsdf_is(m, kBsdfDiffuse)) return diffuse_sample(m, wo, u);
  if (bsdf_is(m, kBsdfMirror)) return mirror_sample(wo);
  if (bsdf_is(m, kBsdfDielectric)) return dielectric_sample(m, wo, u_lobe);
  if (bsdf_is(m, kBsdfConductor)) return conductor_sample(m, wo);
  if (bsdf_is(m, kBsdfThinDielectric)) return thindielectric_sample(m, wo, u_lobe);
  if (bsdf_is(m, kBsdfPlastic)) return plastic_sample(m, wo, u_lobe, u);
  if (bsdf_among(m, kRoughTypes)) return rough_sample(m, wo, u_lobe, u);
  if (bsdf_is(m, kBsdfPrincipled)) return principled_sample(m, wo, u_lobe, u);
  if (bsdf_is(m, kBsdfNull)) return null_sample(wo);
  return kNoBsdfSample;
}

#endif
