// The contract of materials and the switch between them.
//
// Directions are local (+Z = shading normal), unit length, pointing away from the surface.
//   evaluate(wo, wi)    value = f · |cos θ_i| of the non-delta part, 0 where the material does not scatter;
//                       pdf = density of sample() w.r.t. solid angle, 0 for delta lobes
//   sample(wo, u_lobe, u)  weight = value/pdf; `pdf` is w.r.t. solid angle, for delta lobes a discrete probability; pdf 0: no sample.
// Every u is in [0,1).
#ifndef BSDF_GLSL
#define BSDF_GLSL

#include "../adapters.glsl"
#include "../features.glsl"
#include "../material_flags.glsl"
#include "../microfacets.glsl"
#include "../scene.glsl"
#include "../texture.glsl"

// A material at a point, with its parameters evaluated there: the only input of sample, eval and pdf.
struct Material {
  uint header;  // kMaterial*
  vec3 albedo;
  float int_ior;
  float ext_ior;
  vec2 alpha;     // of microfacets
  vec3 specular;  // specular reflectance
  float share;    // of samples taken from the microfacets; the others are from the diffuse base
  vec3 eta;       // complex index of refraction of a metal
  vec3 k;         // see MaterialRecord
  vec4 sheen;     // see gltf.glsl
  vec4 scattered;
  vec4 film;
  vec4 volume;
  vec3 coat;      // the normal of a coat with its own normal
};

const float kLeastRoughness = 1e-3;  // etendue::kMinRoughness

FEATURE(uint, kTextureUses, kConstantTextureUses, 0u)  // maximum number per material

// Value and density of a pair of directions.
struct Scattering {
  vec3 value;  // f · |cos θ_i|
  float pdf;
};

const Scattering kNoScattering = Scattering(vec3(0.0), 0.0);

struct BsdfSample {
  vec3 wi;
  float pdf;
  vec3 weight;
  uint lobe;        // kLobe*; kLobeNone when pdf is 0
  float eta_scale;  // (n_i/n_o)² after a refraction, else 1: undoes the radiance scaling where only energy matters (roulette)
};

const BsdfSample kNoBsdfSample = BsdfSample(vec3(0.0), 0.0, vec3(0.0), kLobeNone, 1.0);

bool is_delta(uint lobe) { return lobe == kLobeDeltaReflection || lobe == kLobeDeltaTransmission; }

// The scene's materials, bit i for kBsdf… = i. A constant, because a SIMD machine computes all materials for all lanes: materials that no surface has
// should not be in the kernel.
layout(constant_id = kConstantBsdfsUsed) const uint kBsdfsUsed = 0xffffffffu;

// Materials that are not built, or that no surface has, are excluded here, before the function, so that the driver does
// not have to read their code.
#define bsdf_is(m, bsdf) ((kBsdfsBuilt & 1u << (bsdf)) != 0u && (kBsdfsUsed & 1u << (bsdf)) != 0u && has_bsdf(m, bsdf))
#define bsdf_among(m, types) ((kBsdfsBuilt & (types)) != 0u && (kBsdfsUsed & (types)) != 0u && has_bsdf_among(m, types))

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

// The types whose parameters do not fit into one texel, and among them those with microfacets.
const uint kRoughTypes = 1u << kBsdfMicrofacet | 1u << kBsdfRoughConductor | 1u << kBsdfRoughDielectric | 1u << kBsdfRoughPlastic;
const uint kRichTypes = 1u << kBsdfGltf | 1u << kBsdfPrincipled | 1u << kBsdfPrincipledThin | kRoughTypes | 1u << kBsdfConductor | 1u << kBsdfThinDielectric | 1u << kBsdfPlastic |
                       1u << kBsdfTintedDielectric;

bool has_bsdf_among(Material m, uint types) {
  return (kBsdfsUsed & types) != 0u && ((kBsdfsUsed & ~types) == 0u || (types >> (m.header & kMaterialTypeMask) & 1u) != 0u);
}

#include "../rough_surface.glsl"
#include "principled.glsl"
#include "principledthin.glsl"
#include "gltf.glsl"

// A material without parameters beyond the first texel.
Material plain_material(uint header, vec3 params) {
  return Material(header, params, params.x, params.y, vec2(1.0), vec3(0.0), 0.0, vec3(1.0), vec3(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec3(0.0, 0.0, 1.0));
}

// A metal stores its index in eta and k; a dielectric stores its two indices in their first components.
Material rich_material(MaterialRecord r) {
  return Material(r.header, r.params, r.eta.x, r.eta.y, vec2(r.alpha_u, r.alpha_v), r.specular, r.share, r.eta, r.k, r.sheen, r.scattered, r.film, r.volume,
                  vec3(0.0, 0.0, 1.0));
}

// Values derived from the parameters at a point.
void resolve_material(inout Material m) {
  if (bsdf_is(m, kBsdfMicrofacet)) {
    m.share = 1.0 - max_component(m.albedo);
    m.specular = vec3(m.share);
  }
  if (bsdf_is(m, kBsdfPlastic) || bsdf_is(m, kBsdfRoughPlastic)) {
    const float coat = dot(m.specular, vec3(1.0)), base = dot(m.albedo, vec3(1.0));
    m.share = coat + base > 0.0 ? coat / (coat + base) : 1.0;
  }
  if (textures_have(kTexturesCoat) && bsdf_is(m, kBsdfRoughPlastic) && m.eta.z != 0.0) resolve_coat(m);
}

// Whether the parameters of some material of the scene do not fit into one texel.
const bool kRich = (kBsdfsUsed & kBsdfsBuilt & kRichTypes) != 0u;

const bool kGltf = (kBsdfsUsed & kBsdfsBuilt & 1u << kBsdfGltf) != 0u;

Material material_of(MaterialRecord r) {
  if (kRich) {
    const Material m = rich_material(r);
    if (bsdf_among(m, kRichTypes)) return m;
  }
  return plain_material(r.header, r.params);
}

// Four floats of a record, of which those whose bits are set are multiplied by the factor.
vec4 textured(vec4 floats, uint bits, vec4 factor, TextureUse use) {
  const bvec4 chosen = notEqual(uvec4(bits) & uvec4(1u, 2u, 4u, 8u), uvec4(0u));
  return mix(floats, clamp(floats * factor, use.least, use.most), chosen);
}

// A loop, because its body is large: a kernel with a copy for each parameter takes seconds to build.
void apply_textures(inout MaterialRecord r, uint row, SurfacePoint at) {
  const MaterialTextures textures = fetch_material_textures(row);
  for (uint i = 0u; i < kTextureUses; ++i) {
    if (textures.begin + i >= textures.end) break;
    const TextureUse use = fetch_texture_use(textures.begin + i);
    const vec4 factor = texture_factor(use.texture_of, at);
    const vec4 a = textured(vec4(r.params, 0.0), use.floats & 7u, factor, use), b = textured(vec4(r.specular, r.share), use.floats >> 4u, factor, use);
    const vec4 c = textured(vec4(r.eta, r.alpha_u), use.floats >> 8u, factor, use), d = textured(vec4(r.k, r.alpha_v), use.floats >> 12u, factor, use);
    if (kGltf) {
      r.sheen = textured(r.sheen, use.floats >> 16u, factor, use);
      r.scattered = textured(r.scattered, use.floats >> 20u, factor, use);
      r.film = textured(r.film, use.floats >> 24u & 0xfu, factor, use);
      if (textures_have(kTexturesTurn) && use.floats == kFloatsTurn) {
        float turn = turn_of(2.0 * factor.x - 1.0, 2.0 * factor.y - 1.0);
        MUTATE(kMutantTurnOfTextureLost, turn = 0.0);
        r.film.z += turn;
      }
    }
    r = MaterialRecord(a.xyz, r.header, b.xyz, b.w, c.xyz, c.w, d.xyz, d.w, r.sheen, r.scattered, r.film, r.volume);
  }
}

// A material at a point, evaluated once per hit.
Material evaluate_material(uint row, SurfacePoint at) {
  uint texels = 1u;
  if (kRich) texels = kRichMaterialTexels;
  if (kGltf) texels = kMaterialTexels;
  MaterialRecord r = fetch_material(row, texels);
  const bool has_textures = kTextured && (kMaterialFlagsSome & kMaterialTextured) != 0u &&
                            ((kMaterialFlagsAll & kMaterialTextured) != 0u || (r.header & kMaterialTextured) != 0u);
  if (has_textures && !textures_have(kTexturesRich)) r.params *= color_factor(fetch_material_textures(row).first, at);
  if (has_textures && textures_have(kTexturesRich)) apply_textures(r, row, at);
  Material m = material_of(r);
  if (has_textures && textures_have(kTexturesRich)) resolve_material(m);
  if (bsdf_is(m, kBsdfPrincipled)) resolve_principled(m);
  if (bsdf_is(m, kBsdfGltf)) resolve_gltf(m);
  return m;
}

// Some glTF material absorbs: its bit, and that of the flag. (glslang loses the position of a constant made with &&.)
const bool kVolumes = (kBsdfsUsed & kBsdfsBuilt & 1u << kBsdfGltf & kMaterialFlagsSome / kMaterialVolume << kBsdfGltf) != 0u;

// Some glTF material has a coat with a normal of its own, or disperses light.
const bool kCoatNormals = (kBsdfsUsed & kBsdfsBuilt & 1u << kBsdfGltf & kMaterialFlagsSome / kMaterialCoatNormal << kBsdfGltf) != 0u;
const bool kDispersive = (kBsdfsUsed & kBsdfsBuilt & 1u << kBsdfGltf & kMaterialFlagsSome / kMaterialDispersive << kBsdfGltf) != 0u;

// Absorption, per scene unit, where light continues in the direction wi, having been in `current` before.
vec3 absorption_toward(Material m, vec3 wi, vec3 current) {
  if (!bsdf_is(m, kBsdfGltf) || gltf_is_sheet(m) || !material_has(m, kMaterialTransmissive)) return current;
  return wi.z < 0.0 ? m.volume.xyz : vec3(0.0);
}

// Beer's law; light from infinitely far away does not get through.
vec3 transmittance(vec3 absorption, float distance) {
  MUTATE(kMutantVolumeClear, return vec3(1.0));
  const vec3 passed = exp(-absorption * (distance / frame.distance_scale));
  return mix(passed, vec3(1.0), equal(absorption, vec3(0.0)));
}

// One function for both, because drivers copy it to each place where it is called, and then need the longer for it.
Scattering bsdf_evaluate(Material m, vec3 wo, vec3 wi) {
  Scattering s = kNoScattering;
  if (bsdf_is(m, kBsdfDiffuse)) s = diffuse_evaluate(m, wo, wi);
  if (bsdf_is(m, kBsdfPlastic)) s = plastic_evaluate(m, wo, wi);
  if (bsdf_among(m, kRoughTypes)) s = rough_evaluate(m, wo, wi);
  if (bsdf_is(m, kBsdfPrincipled)) s = principled_evaluate(m, wo, wi);
  if (bsdf_is(m, kBsdfGltf)) s = gltf_evaluate(m, wo, wi);
  if (bsdf_is(m, kBsdfPrincipledThin)) s = principledthin_evaluate(m, wo, wi);
  return s;
}

BsdfSample bsdf_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  if (bsdf_is(m, kBsdfDiffuse)) return diffuse_sample(m, wo, u);
  if (bsdf_is(m, kBsdfMirror)) return mirror_sample(wo);
  if (bsdf_is(m, kBsdfDielectric)) return dielectric_sample(m, wo, u_lobe);
  if (bsdf_is(m, kBsdfTintedDielectric)) return tinteddielectric_sample(m, wo, u_lobe);
  if (bsdf_is(m, kBsdfConductor)) return conductor_sample(m, wo);
  if (bsdf_is(m, kBsdfThinDielectric)) return thindielectric_sample(m, wo, u_lobe);
  if (bsdf_is(m, kBsdfPlastic)) return plastic_sample(m, wo, u_lobe, u);
  if (bsdf_among(m, kRoughTypes)) return rough_sample(m, wo, u_lobe, u);
  if (bsdf_is(m, kBsdfPrincipled)) return principled_sample(m, wo, u_lobe, u);
  if (bsdf_is(m, kBsdfGltf)) return gltf_sample(m, wo, u_lobe, u);
  if (bsdf_is(m, kBsdfPrincipledThin)) return principledthin_sample(m, wo, u_lobe, u);
  if (bsdf_is(m, kBsdfNull)) return null_sample(wo);
  return kNoBsdfSample;
}

#endif
