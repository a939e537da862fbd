// Nori's microfacet: a diffuse base, and over it microfacets of a dielectric, weighted by ks = 1 − max kd; one-sided.
#include "../fresnel.glsl"

vec3 microfacet_reflectance(Material m, float wo_h) {
  float cos_t;
  return m.specular * fresnel_dielectric(wo_h, m.int_ior / m.ext_ior, cos_t);
}
