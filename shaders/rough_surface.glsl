// What rough materials have in common: microfacets that reflect, over a base that is diffuse or black. One function for all of them, because a SIMD
// machine computes each material of the scene for all lanes. Included by bsdf/bsdf.glsl.

// Value and density of a pair of directions.
struct Scattering {
  vec3 value;  // f · |cos θ_i|
  float pdf;
};

// How much a microfacet reflects that is met at wo_h, the cosine of the angle to its normal.
vec3 facet_reflectance(Material m, float wo_h) {
  vec3 reflectance = vec3(0.0);
  if (bsdf_is(m, kBsdfRoughConductor)) reflectance = roughconductor_reflectance(m, wo_h);
  if (bsdf_is(m, kBsdfMicrofacet)) reflectance = microfacet_reflectance(m, wo_h);
  return reflectance;
}

Facets facets_of(Material m) { return Facets(m.alpha, material_has(m, kMaterialBeckmann)); }

// For directions on the side of the normal. h is their half vector: where it was sampled, as it was sampled, because a narrow lobe would feel its rounding.
Scattering rough_scattering(Material m, vec3 wo, vec3 wi, vec3 h) {
  const Facets f = facets_of(m);
  const float wo_h = dot(wo, h);
  const float density = facet_density(f, h) * 0.25;
  float shadowing = facet_masking(f, wo, wo_h) * facet_masking(f, wi, wo_h);
  MUTATE(kMutantShadowingForgotten, shadowing = facet_masking(f, wo, wo_h));
  vec3 reflectance = facet_reflectance(m, wo_h);
  MUTATE(kMutantFacetFresnelAtNormal, reflectance = facet_reflectance(m, wo.z));
  float coat_pdf = density / visible_area(f, wo);
  MUTATE(kMutantFacetPdfUnmasked, coat_pdf = density * h.z / wo_h);
  Scattering s;
  s.value = reflectance * (density * shadowing / wo.z) + m.albedo * (kInvPi * wi.z);
  s.pdf = m.share * coat_pdf + (1.0 - m.share) * (kInvPi * wi.z);
  return s;
}

Scattering rough_evaluate(Material m, vec3 wo, vec3 wi) {
  if (wo.z <= 0.0 || wi.z <= 0.0) return Scattering(vec3(0.0), 0.0);
  return rough_scattering(m, wo, wi, normalize(wo + wi));
}

BsdfSample rough_sample(Material m, vec3 wo, float u_lobe, vec2 u) {
  if (wo.z <= 0.0) return kNoBsdfSample;
  const bool glossy = u_lobe < m.share;
  vec3 h = sample_facet(facets_of(m), wo, u);
  vec3 wi = 2.0 * dot(wo, h) * h - wo;
  if (!glossy) {
    wi = square_to_cosine_hemisphere(u);
    h = normalize(wo + wi);
  }
  if (wi.z <= 0.0) return kNoBsdfSample;
  const Scattering s = rough_scattering(m, wo, wi, h);
  return s.pdf > 0.0 ? BsdfSample(wi, s.pdf, s.value / s.pdf, glossy ? kLobeGlossyReflection : kLobeDiffuse, 1.0) : kNoBsdfSample;
}
