// Burley's principled material [Burley2012] [Burley2015] with the parameters of Mitsuba; docs/conventions.md, "Principled". Of a Material `specular` holds
// (metallic, spec_trans, spec_tint), `eta` (index of refraction, roughness, flatness), `k` (sheen, sheen_tint, clearcoat), `ext_ior` the coat's roughness.
#include "../fresnel.glsl"
#include "../microfacets.glsl"
#include "../mutants.h"
#include "../warp.glsl"

vec2 principled_alpha(float roughness, float anisotropic) {
  const float squared = roughness * roughness, aspect = sqrt(1.0 - 0.9 * anisotropic);
  return max(vec2(squared / aspect, squared * aspect), vec2(kLeastRoughness));
}

// The meaning of the stored numbers at a point: roughness along and across the tangent, and that of the coat.
void resolve_principled(inout Material m) {
  m.ext_ior = mix(0.1, 0.001, m.alpha.x);
  m.alpha = principled_alpha(m.eta.y, m.share);
}

float principled_clear(Material m) { return (1.0 - m.specular.x) * m.specular.y; }

// Sampling weights of the microfacets, the diffuse base with its sheen, and the coat; not normalised. From behind there
// are only microfacets.
vec3 principled_lobes(Material m, float cos_o, float side) {
  if (side < 0.0) return vec3(1.0, 0.0, 0.0);
  float cos_t;
  const float metallic = m.specular.x, trans = m.specular.y;
  const float mirrored = max(fresnel_dielectric(cos_o, m.eta.x, cos_t), 0.1);
  return vec3(metallic + (1.0 - metallic) * (trans + (1.0 - trans) * mirrored), (1.0 - metallic) * (1.0 - trans + 0.25 * m.k.x), 0.25 * m.k.z);
}

// Probability of transmission at a microfacet that transmits 1 − f.
float principled_passing(Material m, float f, float facets, float side) {
  return side < 0.0 ? 1.0 - f : principled_clear(m) * (1.0 - f) / facets;
}

float fifth_power(float x) { return x * x * (x * x) * x; }
vec3 schlick(vec3 r0, float c) { return r0 + (1.0 - r0) * fifth_power(1.0 - c); }

// Distribution of the coat's microfacets, which has longer tails than GGX.
float coat_density(float alpha, float cos_h) {
  const float a2 = alpha * alpha;
  return (a2 - 1.0) / (kPi * log(a2) * (1.0 + (a2 - 1.0) * cos_h * cos_h));
}

vec3 principled_tint(Material m) {
  const float l = luminance(m.albedo);
  return l > 0.0 ? m.albedo / l : vec3(1.0);
}

// f cos of the diffuse base and the sheen over it, each times its share.
vec3 principled_base(Material m, float base_share, float sheen_share, float cos_o, float cos_i, float cos_d) {
  const float flatness = m.eta.z;
  const float fo = fifth_power(1.0 - cos_o), fi = fifth_power(1.0 - cos_i);
  const float retro = 2.0 * m.eta.y * cos_d * cos_d;
  const float smooth_base = (1.0 - 0.5 * fi) * (1.0 - 0.5 * fo);
  float rough_base = retro * (fo + fi + fo * fi * (retro - 1.0));
  MUTATE(kMutantRetroReflectionLost, rough_base = 0.0);
  const float below = mix(1.0, 0.5 * retro, fo) * mix(1.0, 0.5 * retro, fi);
  const float flat_base = 1.25 * (below * (1.0 / (cos_o + cos_i) - 0.5) + 0.5);
  const vec3 base = m.albedo * (base_share * kInvPi * mix(smooth_base + rough_base, flat_base, flatness));
  const vec3 sheen = mix(vec3(1.0), principled_tint(m), m.k.y) * (sheen_share * m.k.x * fifth_power(1.0 - cos_d));
  return (base + sheen) * cos_i;
}

// Reflectance of a dielectric microfacet at wo_h, by Fresnel's equations f, partly tinted by the base. Schlick's fit uses the cosine on the side of
// the smaller index.
vec3 tinted_reflectance(Material m, float tint, float wo_h, float f, float cos_t) {
  const float root = (m.eta.x - 1.0) / (m.eta.x + 1.0);
  return (1.0 - tint) * f + tint * schlick(principled_tint(m) * (root * root), m.eta.x < 1.0 ? cos_t : wo_h);
}

// Reflectance of a microfacet at wo_h, where a dielectric one reflects f.
vec3 principled_reflectance(Material m, float wo_h, float f, float cos_t, float side) {
  if (side < 0.0) return vec3(principled_clear(m) * f);
  const float metallic = m.specular.x;
  return (1.0 - metallic) * tinted_reflectance(m, m.specular.z, wo_h, f, cos_t) + metallic * schlick(m.albedo, wo_h);
}

// wo is on the side z > 0; h is the half vector, eta is n_i/n_o for transmission.
Scattering principled_scattering(Material m, vec3 wo, vec3 wi, vec3 h, float eta, float side) {
  const Facets facets = Facets(m.alpha, false);
  const float wo_h = dot(wo, h), wi_h = dot(wi, h);
  const float density = facet_density(facets, h), seen = density / visible_area(facets, wo);
  const float shadowing = facet_masking(facets, wo, wo_h) * facet_masking(facets, wi, wi_h) / wo.z;
  const vec3 lobes = principled_lobes(m, wo.z, side);
  const float total = lobes.x + lobes.y + lobes.z;
  float cos_t;
  const float f = fresnel_dielectric(wo_h, eta, cos_t);
  const float passing = principled_passing(m, f, lobes.x, side);
  if (wi.z < 0.0) {
    const float sum = (1.0 - eta * eta) / (wo_h + eta * cos_t);
    const float by_h = eta * eta * cos_t / (sum * sum);
    return Scattering(sqrt(m.albedo) * (principled_clear(m) * (1.0 - f) * density * shadowing * wo_h * by_h / (eta * eta)),
                      lobes.x / total * passing * seen * wo_h * by_h);
  }
  Scattering s = Scattering(principled_reflectance(m, wo_h, f, cos_t, side) * (0.25 * density * shadowing), lobes.x / total * (1.0 - passing) * 0.25 * seen);
  if (side < 0.0) return s;
  s.value += principled_base(m, (1.0 - m.specular.x) * (1.0 - m.specular.y), 1.0 - m.specular.x, wo.z, wi.z, wi_h);
  s.pdf += lobes.y / total * kInvPi * wi.z;
  if (m.k.z > 0.0) {
    const Facets smooth_facets = Facets(vec2(0.25), false);
    const float coat = coat_density(m.ext_ior, h.z);
    float g = facet_masking(smooth_facets, wo, wo_h) * facet_masking(smooth_facets, wi, wi_h);
    MUTATE(kMutantCoatUnmasked, g = 1.0);
    s.value += vec3(0.25 * m.k.z * schlick(vec3(0.04), wo_h).x * coat * g * wi.z);
    s.pdf += lobes.z / total * 0.25 * coat * h.z / wo_h;
  }
  return s;
}

Scattering principled_evaluate(Material m, vec3 wo, vec3 wi) {
  const float side = wo.z < 0.0 ? -1.0 : 1.0;
  const float eta = side > 0.0 ? m.eta.x : 1.0 / m.eta.x;
  wo.z *= side;
  wi.z *= side;
  const bool clear = principled_clear(m) > 0.0;
  if (wo.z <= 0.0 || wi.z == 0.0 || ((side < 0.0 || wi.z < 0.0) && !clear)) return kNoScattering;
  vec3 h = normalize(wi.z > 0.0 ? wo + wi : wo + eta * wi);
  h = h.z < 0.0 ? -h : h;
  if (dot(wo, h) <= 0.0 || dot(wi, h) * wi.z <= 0.0) return kNoScattering;
  return principled_scattering(m, wo, wi, h, eta, side);
}

BsdfSample principled_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  const float side = wo.z < 0.0 ? -1.0 : 1.0;
  const float eta = side > 0.0 ? m.eta.x : 1.0 / m.eta.x;
  wo.z *= side;
  if (wo.z <= 0.0 || (side < 0.0 && principled_clear(m) == 0.0)) return kNoBsdfSample;
  const vec3 lobes = principled_lobes(m, wo.z, side);
  const float x = u_lobe * (lobes.x + lobes.y + lobes.z);
  uint lobe = kLobeGlossyReflection;
  vec3 wi, h;
  if (x < lobes.x) {
    h = sample_facet(Facets(m.alpha, false), wo, u);
    const float wo_h = dot(wo, h);
    float cos_t;
    const float f = fresnel_dielectric(wo_h, eta, cos_t);
    wi = 2.0 * wo_h * h - wo;
    if (x >= lobes.x * (1.0 - principled_passing(m, f, lobes.x, side))) {
      wi = (wo_h / eta - cos_t) * h - wo / eta;
      lobe = kLobeGlossyTransmission;
    }
  } else if (x < lobes.x + lobes.y) {
    wi = square_to_cosine_hemisphere(u);
    h = normalize(wo + wi);
    lobe = kLobeDiffuse;
  } else {
    const float a2 = m.ext_ior * m.ext_ior;
    const float z = sqrt((1.0 - pow(a2, 1.0 - u.x)) / (1.0 - a2));
    h = vec3(sqrt(max(0.0, 1.0 - z * z)) * cos_sin_turn(u.y), z);
    wi = 2.0 * dot(wo, h) * h - wo;
  }
  const bool through = lobe == kLobeGlossyTransmission;
  if (dot(wo, h) <= 0.0 || (through ? wi.z >= 0.0 : wi.z <= 0.0)) return kNoBsdfSample;
  const Scattering s = principled_scattering(m, wo, wi, h, eta, side);
  wi.z *= side;
  return s.pdf > 0.0 ? BsdfSample(wi, s.pdf, s.value / s.pdf, lobe, through ? eta * eta : 1.0) : kNoBsdfSample;
}
