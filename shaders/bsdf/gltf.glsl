// The material of glTF 2.0; docs/conventions.md, "glTF". In a Material, `specular` holds the reflectance at normal incidence of the non-metallic
// part, `share` that at grazing angles, `eta` (index of refraction, roughness, metallic), `k` (transmission, diffuse transmission, clearcoat),
// `ext_ior` the coat's roughness, `sheen` its colour and roughness, `scattered` the colour of diffusely transmitted light and the share of the film,
// `film` (index, thickness in nanometres, rotation of the tangent, first texel of the sheen's albedo), `volume` the absorption of a solid and, if
// there is one, 1 plus the excess of the index for blue, as a share of the index minus 1.
#include "../fresnel.glsl"
#include "../microfacets.glsl"
#include "../mutants.h"
#include "../scene.glsl"
#include "../thin_film.glsl"
#include "../warp.glsl"

// The meaning of the stored numbers at a point.
void resolve_gltf(inout Material m) {
  const float alpha = m.eta.y * m.eta.y, anisotropy = m.alpha.x, coat = m.alpha.y;
  const float root = (m.eta.x - 1.0) / (m.eta.x + 1.0);
  m.specular = min(m.specular * (root * root), vec3(1.0)) * m.share;
  m.alpha = max(vec2(mix(alpha, 1.0, anisotropy * anisotropy), alpha), vec2(kLeastRoughness));
  m.ext_ior = max(coat * coat, kLeastRoughness);
  m.eta.x = max(m.eta.x, 1.001);
}

bool gltf_is_sheet(Material m) { return m.volume.w == 0.0; }
vec2 turned(vec2 v, vec2 turn) { return vec2(v.x * turn.x - v.y * turn.y, v.x * turn.y + v.y * turn.x); }

// An upper bound for the mean of (1 − c)⁵ over GGX microfacets visible from a direction of this cosine, for any azimuth: fitted for this purpose.
float grazing_share(float cosine, float alpha) {
  const float x = max(0.0, 1.0 - cosine);
  return min(min(fifth_power(x), x * x / (1.0 + 16.0 * alpha)) + 0.0026, 1.0);
}

// An upper bound for the reflectance of the non-metallic part for light from a direction of this cosine.
float gltf_boundary(Material m, float cosine) {
  const float grazing = grazing_share(cosine, min(m.alpha.x, m.alpha.y));
  const float along = max_component(m.specular), bare = along + (m.share - along) * grazing;
  if (!material_has(m, kMaterialFilm)) return bare;
  const float film = max_component(film_bound(Film(m.film.x, m.film.y, m.specular)));
  return mix(bare, film + (1.0 - film) * grazing, m.scattered.w);
}
float gltf_coat(Material m, float cosine) { return m.k.z * (0.04 + 0.96 * grazing_share(cosine, m.ext_ior)); }

vec3 gltf_dielectric(Material m, float c) {
  vec3 reflectance = m.specular + (m.share - m.specular) * fifth_power(1.0 - c);
  if (material_has(m, kMaterialFilm)) reflectance = mix(reflectance, film_reflectance(Film(m.film.x, m.film.y, m.specular), c), m.scattered.w);
  return reflectance;
}
vec3 gltf_metal(Material m, float c) {
  vec3 reflectance = schlick(m.albedo, c);
  if (material_has(m, kMaterialFilm)) reflectance = mix(reflectance, film_reflectance(Film(m.film.x, m.film.y, m.albedo), c), m.scattered.w);
  return reflectance;
}

// Sheen: microfibres [Estevez2017].
float sheen_alpha(Material m) { return max(m.sheen.w * m.sheen.w, 0.01); }
float sheen_curve(vec4 a, float e, float x) { return a.x / (1.0 + a.y * pow(x, a.z)) + a.w * x + e; }
float sheen_lambda(float cosine, float alpha) {
  const float t = (1.0 - alpha) * (1.0 - alpha);
  const vec4 a = mix(vec4(21.5473, 3.82987, 0.19823, -1.97760), vec4(25.3245, 3.32435, 0.16801, -1.27393), t);
  const float e = mix(-4.32054, -4.85967, t);
  return cosine < 0.5 ? exp(sheen_curve(a, e, cosine)) : exp(2.0 * sheen_curve(a, e, 0.5) - sheen_curve(a, e, 1.0 - cosine));
}
float sheen_lobe(float alpha, float cos_o, float cos_i, float cos_h) {
  const float density = (2.0 + 1.0 / alpha) * pow(max(0.0, 1.0 - cos_h * cos_h), 0.5 / alpha) * (0.5 * kInvPi);
  return density / ((1.0 + sheen_lambda(cos_o, alpha) + sheen_lambda(cos_i, alpha)) * 4.0 * cos_o);
}

// Albedo of white sheen, from a table: linear between cosines and between roughnesses.
float sheen_row(uint first, float cosine) {
  const float x = min(cosine, 1.0) * float(kSheenCosines - 1u);
  const uint node = min(uint(x), kSheenCosines - 2u);
  return mix(fetch_transmittances(first + node / 4u)[node % 4u], fetch_transmittances(first + (node + 1u) / 4u)[(node + 1u) % 4u], x - float(node));
}
float sheen_albedo(Material m, float cosine) {
  const float y = clamp((sqrt(sheen_alpha(m)) - 0.1) / 0.9, 0.0, 1.0) * float(kSheenRoughnesses - 1u);
  const uint row = min(uint(y), kSheenRoughnesses - 2u), first = uint(m.film.w) + row * (kSheenCosines / 4u);
  return mix(sheen_row(first, cosine), sheen_row(first + kSheenCosines / 4u, cosine), y - float(row));
}

// The light that coat and sheen leave to the layers below them, where it arrives or leaves through them in front.
struct Layers {
  float below_coat;
  float below_sheen;
  float sheen_norm;  // brings the sheen's albedo to at most 1
};
// `coat_o` and `coat_i` are the cosines with the normal of the coat.
Layers gltf_layers(Material m, float cos_o, float cos_i, float coat_o, float coat_i) {
  Layers layers = Layers(1.0 - max(gltf_coat(m, coat_o), gltf_coat(m, coat_i)), 1.0, 1.0);
  MUTATE(kMutantGltfCoatAdded, layers.below_coat = 1.0);
  const float sheen = max_component(m.sheen.xyz);
  if (sheen > 0.0) {
    const float most = max(sheen_albedo(m, cos_o), sheen_albedo(m, cos_i));
    layers.below_sheen = 1.0 - sheen * min(most, 1.0);
    layers.sheen_norm = 1.0 / max(most, 1.0);
  }
  return layers;
}

// Sampling weights of the microfacets, of the diffuse base in front and behind, of the coat, and of the sheen; not normalised.
struct GltfLobes {
  float facets, front, behind, coat, sheen;
};
GltfLobes gltf_lobes(Material m, float cos_o, float coat_o, bool front) {
  const float rest = 1.0 - m.eta.z, clear = rest * m.k.x, opaque = rest * (1.0 - m.k.x);
  if (!front) return GltfLobes(clear, 0.0, opaque * m.k.y, 0.0, 0.0);
  const float mirrored = max(max_component(gltf_dielectric(m, cos_o)), 0.1);
  return GltfLobes(m.eta.z + clear + opaque * mirrored, opaque * (1.0 - m.k.y), opaque * m.k.y, m.k.z * max(gltf_coat(m, coat_o), 0.1),
                   0.5 * max_component(m.sheen.xyz));
}
float lobes_total(GltfLobes l) { return l.facets + l.front + l.behind + l.coat + l.sheen; }

// For microfacets hit at wo_h: the cosine outside, by which they reflect, and the probability of transmission.
float gltf_outer(Material m, float wo_h, float eta) {
  float cos_t;
  fresnel_dielectric(wo_h, eta, cos_t);
  return eta < 1.0 ? cos_t : wo_h;
}
float gltf_passing(Material m, GltfLobes lobes, float outer, float eta) {
  const float clear = (1.0 - m.eta.z) * m.k.x;
  const bool total = eta < 1.0 && outer == 0.0;
  return total || lobes.facets == 0.0 ? 0.0 : clear * (1.0 - max_component(gltf_dielectric(m, outer))) / lobes.facets;
}

// A pair of directions seen from the side of wo.
struct GltfPair {
  vec3 wo, wi, h;  // h: the half vector, 0 where there is none that microfacets could have
  float eta;       // n_i/n_o for refraction; 1 for sheets
  vec3 coat;       // the normal of a coat with its own normal
  bool front;      // that side has all layers
};

bool has_coat_normal(Material m) { return material_has(m, kMaterialCoatNormal); }
// The normal of the coat on the side of wo, as a pair of directions is seen.
vec3 gltf_coat_normal(Material m, float side, vec2 turn) {
  const vec3 n = vec3(turned(m.coat.xy, turn), m.coat.z * side);
  return n.z < 0.0 ? -n : n;
}
float coat_cosine(Material m, GltfPair p, vec3 w) { return has_coat_normal(m) ? abs(dot(w, p.coat)) : abs(w.z); }

Layers pair_layers(Material m, GltfPair p) {
  if (p.wi.z < 0.0 && !gltf_is_sheet(m)) {
    const float outside = p.front ? p.wo.z : -p.wi.z;
    const float coat = coat_cosine(m, p, p.front ? p.wo : p.wi);
    return gltf_layers(m, outside, outside, coat, coat);
  }
  return p.front ? gltf_layers(m, p.wo.z, abs(p.wi.z), coat_cosine(m, p, p.wo), coat_cosine(m, p, p.wi)) : Layers(1.0, 1.0, 1.0);
}

// The diffuse base below the boundary, without the layers above it.
Scattering gltf_base(Material m, GltfPair p, GltfLobes lobes) {
  const float cos_i = abs(p.wi.z);
  float unreflected = 1.0 - max(gltf_boundary(m, p.wo.z), gltf_boundary(m, cos_i));
  MUTATE(kMutantGltfBaseUndimmed, unreflected = 1.0);
  const float base = (1.0 - m.eta.z) * (1.0 - m.k.x) * unreflected * kInvPi * cos_i;
  if (p.wi.z < 0.0) return Scattering(m.scattered.xyz * (base * m.k.y), lobes.behind * kInvPi * cos_i);
  return p.front ? Scattering(m.albedo * (base * (1.0 - m.k.y)), lobes.front * kInvPi * cos_i) : kNoScattering;
}

// Reflection and transmission of microfacets.
Scattering gltf_facets(Material m, GltfPair p, GltfLobes lobes) {
  const bool through = p.wi.z < 0.0, sheet = gltf_is_sheet(m);
  const Facets facets = Facets(m.alpha, false);
  const float wo_h = dot(p.wo, p.h), clear = (1.0 - m.eta.z) * m.k.x;
  const vec3 image = vec3(p.wi.xy, sheet ? abs(p.wi.z) : p.wi.z);
  const float outer = gltf_outer(m, wo_h, p.eta), passing = lobes.facets * gltf_passing(m, lobes, outer, p.eta);
  const float density = facet_density(facets, p.h), seen = density / visible_area(facets, p.wo);
  const float shown = density * facet_masking(facets, p.wo, wo_h) * facet_masking(facets, image, dot(image, p.h)) / p.wo.z;
  const vec3 dielectric = gltf_dielectric(m, outer);
  if (!through) {
    const vec3 reflectance = p.front ? mix(dielectric, gltf_metal(m, outer), m.eta.z) : clear * dielectric;
    return Scattering(reflectance * (0.25 * shown), (lobes.facets - passing) * 0.25 * seen);
  }
  float by_h = 0.25 / wo_h;
  if (!sheet) {
    float cos_t;
    fresnel_dielectric(wo_h, p.eta, cos_t);
    const float sum = (1.0 - p.eta * p.eta) / (wo_h + p.eta * cos_t);
    by_h = p.eta * p.eta * cos_t / (sum * sum);
  }
  return Scattering(m.albedo * (clear * (1.0 - max_component(dielectric)) * shown * wo_h * by_h / (p.eta * p.eta)), passing * seen * wo_h * by_h);
}

Scattering gltf_clearcoat(Material m, GltfPair p, GltfLobes lobes) {
  const Facets coat = Facets(vec2(m.ext_ior), false);
  if (has_coat_normal(m)) {
    const ShadingFrame turned_frame = make_frame(p.coat);
    p.wo = to_local(turned_frame, p.wo);
    p.wi = to_local(turned_frame, p.wi);
    p.h = to_local(turned_frame, p.h);
    if (p.wo.z <= 0.0 || p.h.z <= 0.0) return kNoScattering;
  }
  const float wo_h = dot(p.wo, p.h), density = facet_density(coat, p.h);
  const float shown = density * facet_masking(coat, p.wo, wo_h) * facet_masking(coat, p.wi, wo_h) / p.wo.z;
  const float value = p.wi.z > 0.0 ? 0.25 * m.k.z * (0.04 + 0.96 * fifth_power(1.0 - wo_h)) * shown : 0.0;
  return Scattering(vec3(value), lobes.coat * 0.25 * density / visible_area(coat, p.wo));
}

Scattering gltf_scattering(Material m, GltfPair p) {
  const GltfLobes lobes = gltf_lobes(m, p.wo.z, coat_cosine(m, p, p.wo), p.front);
  const Layers layers = pair_layers(m, p);
  Scattering s = gltf_base(m, p, lobes);
  if (p.h.z > 0.0) {
    const Scattering facets = gltf_facets(m, p, lobes);
    s = Scattering(s.value + facets.value, s.pdf + facets.pdf);
  }
  s.value *= layers.below_coat * layers.below_sheen;
  if (p.front && p.wi.z > 0.0) {
    if (lobes.coat > 0.0) {
      const Scattering coat = gltf_clearcoat(m, p, lobes);
      s = Scattering(s.value + coat.value, s.pdf + coat.pdf);
    }
    if (lobes.sheen > 0.0) {
      s.value += m.sheen.xyz * (sheen_lobe(sheen_alpha(m), p.wo.z, p.wi.z, p.h.z) * layers.sheen_norm * layers.below_coat);
      s.pdf += lobes.sheen * 0.5 * kInvPi;
    }
  }
  const float total = lobes_total(lobes);
  return total > 0.0 ? Scattering(s.value, s.pdf / total) : kNoScattering;
}

// n_i/n_o for refraction, seen from a side.
float gltf_bending(Material m, float side) { return gltf_is_sheet(m) ? 1.0 : side > 0.0 ? m.eta.x : 1.0 / m.eta.x; }

// Half vector of directions seen from the side of wo; behind a sheet that of the mirror image.
vec3 gltf_half_vector(Material m, vec3 wo, vec3 wi, float eta) {
  if (gltf_is_sheet(m)) wi.z = abs(wi.z);
  vec3 h = normalize(wi.z > 0.0 ? wo + wi : wo + eta * wi);
  h = h.z < 0.0 ? -h : h;
  return dot(wo, h) > 0.0 && dot(wi, h) * wi.z > 0.0 ? h : vec3(0.0);
}

Scattering gltf_evaluate(Material m, vec3 wo, vec3 wi) {
  const float side = wo.z < 0.0 ? -1.0 : 1.0, eta = gltf_bending(m, side);
  const vec2 turn = cos_sin_turn(m.film.z) * vec2(1.0, -1.0);
  wo = vec3(turned(wo.xy, turn), wo.z * side);
  wi = vec3(turned(wi.xy, turn), wi.z * side);
  const bool clear = material_has(m, kMaterialTransmissive);
  if (wo.z <= 0.0 || wi.z == 0.0 || (!clear && (side < 0.0 || wi.z < 0.0))) return kNoScattering;
  return gltf_scattering(m, GltfPair(wo, wi, gltf_half_vector(m, wo, wi, eta), eta, gltf_coat_normal(m, side, turn), side > 0.0 || gltf_is_sheet(m)));
}

// A direction sampled from microfacets, with the normal that was hit.
uint gltf_facet_direction(Material m, inout GltfPair p, GltfLobes lobes, float x, vec2 u) {
  p.h = sample_facet(Facets(m.alpha, false), p.wo, u);
  const float wo_h = dot(p.wo, p.h);
  p.wi = 2.0 * wo_h * p.h - p.wo;
  if (x < lobes.facets * (1.0 - gltf_passing(m, lobes, gltf_outer(m, wo_h, p.eta), p.eta))) return kLobeGlossyReflection;
  if (gltf_is_sheet(m)) {
    p.wi.z = -p.wi.z;
    return kLobeGlossyTransmission;
  }
  float cos_t;
  fresnel_dielectric(wo_h, p.eta, cos_t);
  p.wi = (wo_h / p.eta - cos_t) * p.h - p.wo / p.eta;
  return kLobeGlossyTransmission;
}

// A direction of the lobe that x, in [0, 1), chooses.
uint gltf_direction(Material m, inout GltfPair p, float x, vec2 u) {
  const GltfLobes lobes = gltf_lobes(m, p.wo.z, coat_cosine(m, p, p.wo), p.front);
  x *= lobes_total(lobes);
  if (x < lobes.facets) return gltf_facet_direction(m, p, lobes, x, u);
  x -= lobes.facets;
  if (x < lobes.front + lobes.behind) {
    p.wi = square_to_cosine_hemisphere(u);
    const bool through = x >= lobes.front;
    if (through) p.wi.z = -p.wi.z;
    p.h = gltf_half_vector(m, p.wo, p.wi, p.eta);
    return through ? kLobeDiffuseTransmission : kLobeDiffuse;
  }
  if (x - lobes.front - lobes.behind < lobes.coat) {
    const Facets coat = Facets(vec2(m.ext_ior), false);
    if (has_coat_normal(m)) {
      const ShadingFrame turned_frame = make_frame(p.coat);
      p.h = to_world(turned_frame, sample_facet(coat, to_local(turned_frame, p.wo), u));
    } else {
      p.h = sample_facet(coat, p.wo, u);
    }
    p.wi = 2.0 * dot(p.wo, p.h) * p.h - p.wo;
    return kLobeGlossyReflection;
  }
  const float z = 1.0 - u.x;
  p.wi = vec3(sqrt(max(0.0, 1.0 - z * z)) * cos_sin_turn(u.y), z);
  p.h = normalize(p.wo + p.wi);
  return kLobeDiffuse;
}

BsdfSample gltf_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  const float side = wo.z < 0.0 ? -1.0 : 1.0, eta = gltf_bending(m, side);
  const vec2 turn = cos_sin_turn(m.film.z);
  if (wo.z == 0.0 || (side < 0.0 && !material_has(m, kMaterialTransmissive))) return kNoBsdfSample;
  const vec2 back = turn * vec2(1.0, -1.0);
  GltfPair p = GltfPair(vec3(turned(wo.xy, back), wo.z * side), vec3(0.0), vec3(0.0), eta, gltf_coat_normal(m, side, back), side > 0.0 || gltf_is_sheet(m));
  const uint lobe = gltf_direction(m, p, u_lobe, u);
  const bool through = lobe == kLobeGlossyTransmission || lobe == kLobeDiffuseTransmission;
  const bool glossy = lobe == kLobeGlossyReflection || lobe == kLobeGlossyTransmission;
  if ((glossy && dot(p.wo, p.h) <= 0.0) || (through ? p.wi.z >= 0.0 : p.wi.z <= 0.0)) return kNoBsdfSample;
  const Scattering s = gltf_scattering(m, p);
  const vec3 wi = vec3(turned(p.wi.xy, turn), p.wi.z * side);
  return s.pdf > 0.0 ? BsdfSample(wi, s.pdf, s.value / s.pdf, lobe, through ? eta * eta : 1.0) : kNoBsdfSample;
}
