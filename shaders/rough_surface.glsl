// Common code of rough materials: reflecting microfacets over a base that is diffuse, clear or black. One function for all of them, because a SIMD
// machine computes each material of the scene for all lanes. Included by bsdf/bsdf.glsl.

// Reflectance of a microfacet at wo_h, the cosine of the angle to its normal; for a clear boundary with relative index eta.
vec3 facet_reflectance(Material m, float wo_h, float eta, out float clear_share) {
  vec3 reflectance = vec3(0.0);
  clear_share = 0.0;
  if (bsdf_is(m, kBsdfRoughConductor)) reflectance = roughconductor_reflectance(m, wo_h);
  if (bsdf_is(m, kBsdfMicrofacet)) reflectance = microfacet_reflectance(m, wo_h);
  if (bsdf_is(m, kBsdfRoughPlastic)) reflectance = roughplastic_reflectance(m, wo_h);
  if (bsdf_is(m, kBsdfRoughDielectric)) {
    float cos_t;
    clear_share = fresnel_dielectric(wo_h, eta, cos_t);
    reflectance = m.specular * clear_share;
  }
  return reflectance;
}

Facets facets_of(Material m) { return Facets(m.alpha, material_has(m, kMaterialBeckmann)); }

// The materials with two sides see the side that wo is on as z > 0.
float rough_side(Material m, vec3 wo) { return bsdf_is(m, kBsdfRoughDielectric) && wo.z < 0.0 ? -1.0 : 1.0; }

// n_i/n_o for transmission through a clear boundary; 1 for all others.
float rough_eta(Material m, float side) {
  const float eta = m.int_ior / m.ext_ior;
  return bsdf_is(m, kBsdfRoughDielectric) ? (side > 0.0 ? eta : 1.0 / eta) : 1.0;
}

// The base under the microfacets.
Scattering rough_base(Material m, float cos_o, float cos_i, float share) {
  Scattering s = Scattering(m.albedo * (kInvPi * cos_i), (1.0 - share) * (kInvPi * cos_i));
  if (bsdf_is(m, kBsdfRoughPlastic)) {
    const float seen = roughplastic_passes(m, cos_o);
    float lit = roughplastic_passes(m, cos_i);
    MUTATE(kMutantTransmittanceOnce, lit = 1.0);
    s.value = coated_base(m, cos_i, lit, seen);
  }
  if (bsdf_is(m, kBsdfRoughDielectric)) s = kNoScattering;
  return s;
}

// Share of samples that go to the microfacets, of a material with a base that scatters.
float facet_share(Material m, float cos_o) {
  float share = m.share;
  if (bsdf_is(m, kBsdfRoughPlastic)) share = coat_share(m, roughplastic_passes(m, cos_o));
  return share;
}

// wo is on the side z > 0. h is the half vector: if it was sampled, exactly as sampled, because rounding would affect a narrow lobe.
Scattering rough_scattering(Material m, vec3 wo, vec3 wi, vec3 h, float eta) {
  const Facets f = facets_of(m);
  const float wo_h = dot(wo, h);
  const float density = facet_density(f, h);
  const float seen = density / visible_area(f, wo);
  float shadowing = facet_masking(f, wo, wo_h) * facet_masking(f, wi, dot(wi, h)) / wo.z;
  MUTATE(kMutantShadowingForgotten, shadowing = facet_masking(f, wo, wo_h) / wo.z);
  if (bsdf_is(m, kBsdfRoughDielectric) && wi.z < 0.0) {
    const Passing p = roughdielectric_through(m, eta, wo_h, density, seen, shadowing);
    return Scattering(p.value, p.pdf);
  }
  float clear_share;
  vec3 reflectance = facet_reflectance(m, wo_h, eta, clear_share);
  MUTATE(kMutantFacetFresnelAtNormal, reflectance = facet_reflectance(m, wo.z, eta, clear_share));
  float coat_pdf = 0.25 * seen;
  MUTATE(kMutantFacetPdfUnmasked, coat_pdf = 0.25 * density * h.z / wo_h);
  const float share = bsdf_is(m, kBsdfRoughDielectric) ? clear_share : facet_share(m, wo.z);
  Scattering s = rough_base(m, wo.z, wi.z, share);
  s.value += reflectance * (0.25 * density * shadowing);
  s.pdf += share * coat_pdf;
  return s;
}

Scattering rough_evaluate(Material m, vec3 wo, vec3 wi) {
  const float side = rough_side(m, wo);
  const float eta = rough_eta(m, side);
  wo.z *= side;
  wi.z *= side;
  if (wo.z <= 0.0 || wi.z == 0.0 || (wi.z < 0.0 && !bsdf_is(m, kBsdfRoughDielectric))) return kNoScattering;
  vec3 h = normalize(wi.z > 0.0 ? wo + wi : wo + eta * wi);
  h = h.z < 0.0 ? -h : h;
  if (dot(wo, h) <= 0.0 || dot(wi, h) * wi.z <= 0.0) return kNoScattering;
  return rough_scattering(m, wo, wi, h, eta);
}

BsdfSample rough_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  const float side = rough_side(m, wo);
  const float eta = rough_eta(m, side);
  wo.z *= side;
  if (wo.z <= 0.0) return kNoBsdfSample;
  vec3 h = sample_facet(facets_of(m), wo, u);
  const float wo_h = dot(wo, h);
  vec3 wi = 2.0 * wo_h * h - wo;
  uint lobe = kLobeGlossyReflection;
  if (bsdf_is(m, kBsdfRoughDielectric)) {
    float cos_t;
    if (u_lobe >= fresnel_dielectric(wo_h, eta, cos_t)) {
      wi = (wo_h / eta - cos_t) * h - wo / eta;
      lobe = kLobeGlossyTransmission;
    }
  } else if (u_lobe >= facet_share(m, wo.z)) {
    wi = square_to_cosine_hemisphere(u);
    h = normalize(wo + wi);
    lobe = kLobeDiffuse;
  }
  const bool through = lobe == kLobeGlossyTransmission;
  if (wo_h <= 0.0 || (through ? wi.z >= 0.0 : wi.z <= 0.0)) return kNoBsdfSample;
  const Scattering s = rough_scattering(m, wo, wi, h, eta);
  wi.z *= side;
  return s.pdf > 0.0 ? BsdfSample(wi, s.pdf, s.value / s.pdf, lobe, through ? eta * eta : 1.0) : kNoBsdfSample;
}
