// Burley's material of a thin sheet [Burley2015] with the parameters of Mitsuba; docs/conventions.md, "Principled". It is the same from both sides. Of a
// Material `specular` holds (diff_trans, spec_trans, spec_tint), `eta` (index of refraction, roughness, flatness), `k` (sheen, sheen_tint).
#include "../fresnel.glsl"
#include "../microfacets.glsl"
#include "../mutants.h"
#include "../warp.glsl"

// Transmitted light is refracted twice and spread less than reflected light.
Facets sheet_facets(Material m, bool through) {
  float scale = through ? 0.65 * m.eta.x - 0.35 : 1.0;
  MUTATE(kMutantSheetRoughnessUnscaled, scale = 1.0);
  return Facets(principled_alpha(scale * m.eta.y, m.share), false);
}

// Sampling weights of reflecting and transmitting microfacets, and of the base in front and behind; not normalised.
vec4 sheet_lobes(Material m, float cos_o) {
  float cos_t;
  const float f = fresnel_dielectric(cos_o, m.eta.x, cos_t), trans = m.specular.y, behind = 0.5 * m.specular.x;
  return vec4(trans * max(f, 0.1), trans * max(1.0 - f, 0.1), (1.0 - trans) * (1.0 - behind) * (1.0 + 0.25 * m.k.x), (1.0 - trans) * behind);
}

// Value and density for directions seen from the side of wo; h is the half vector of wo and wi, where wi is mirrored to
// that side if it is behind.
Scattering sheet_scattering(Material m, vec3 wo, vec3 wi, vec3 h) {
  const bool through = wi.z < 0.0;
  const Facets facets = sheet_facets(m, through);
  const vec3 mirrored = vec3(wi.xy, abs(wi.z));
  const float wo_h = dot(wo, h), density = facet_density(facets, h);
  const float shadowing = facet_masking(facets, wo, wo_h) * facet_masking(facets, mirrored, wo_h) / wo.z;
  const float seen = 0.25 * density / visible_area(facets, wo);
  const float clear = 0.25 * m.specular.y * density * shadowing, opaque = 1.0 - m.specular.y;
  float behind = 0.5 * m.specular.x;
  const vec4 lobes = sheet_lobes(m, wo.z);
  const float total = lobes.x + lobes.y + lobes.z + lobes.w;
  MUTATE(kMutantSheetPassesTwice, behind = m.specular.x);
  float cos_t;
  const float f = fresnel_dielectric(wo_h, m.eta.x, cos_t);
  if (through) {
    // The microfacet must face away from the direction of the light.
    const float passes = dot(wi, h) < 0.0 ? (1.0 - f) * clear : 0.0;
    return Scattering(m.albedo * (passes + opaque * behind * kInvPi * mirrored.z), (lobes.y * seen + lobes.w * kInvPi * mirrored.z) / total);
  }
  const float front = opaque * (1.0 - behind);
  return Scattering(tinted_reflectance(m, m.specular.z, wo_h, f, cos_t) * clear + principled_base(m, front, front, wo.z, wi.z, wo_h),
                    (lobes.x * seen + lobes.z * kInvPi * wi.z) / total);
}

Scattering principledthin_evaluate(Material m, vec3 wo, vec3 wi) {
  const float side = wo.z < 0.0 ? -1.0 : 1.0;
  wo.z *= side;
  wi.z *= side;
  if (wo.z <= 0.0 || wi.z == 0.0) return kNoScattering;
  return sheet_scattering(m, wo, wi, normalize(wo + vec3(wi.xy, abs(wi.z))));
}

BsdfSample principledthin_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  const float side = wo.z < 0.0 ? -1.0 : 1.0;
  wo.z *= side;
  if (wo.z <= 0.0) return kNoBsdfSample;
  const vec4 lobes = sheet_lobes(m, wo.z);
  const float x = u_lobe * (lobes.x + lobes.y + lobes.z + lobes.w);
  const bool glossy = x < lobes.x + lobes.y;
  const bool through = glossy ? x >= lobes.x : x >= lobes.x + lobes.y + lobes.z;
  vec3 wi, h;
  if (glossy) {
    h = sample_facet(sheet_facets(m, through), wo, u);
    wi = 2.0 * dot(wo, h) * h - wo;
  } else {
    wi = square_to_cosine_hemisphere(u);
    h = normalize(wo + wi);
  }
  if (dot(wo, h) <= 0.0 || wi.z <= 0.0) return kNoBsdfSample;
  if (through) wi.z = -wi.z;
  const Scattering s = sheet_scattering(m, wo, wi, h);
  const uint lobe = glossy ? (through ? kLobeGlossyTransmission : kLobeGlossyReflection) : through ? kLobeDiffuseTransmission : kLobeDiffuse;
  wi.z *= side;
  return s.pdf > 0.0 ? BsdfSample(wi, s.pdf, s.value / s.pdf, lobe, 1.0) : kNoBsdfSample;
}
