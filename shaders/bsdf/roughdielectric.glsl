// Rough boundary between two clear media [Walter2007]: its microfacets reflect and refract by Fresnel's equations. wo lies on the side z > 0
// here, eta is n_i/n_o of what passes.
#include "../fresnel.glsl"
#include "../mutants.h"

// Light that passes the boundary at a microfacet of normal h. `seen` is the density of h by what wo sees of it, `shadowing` the masking of both directions over
// the cosine of wo.
struct Passing {
  vec3 value;
  float pdf;
};

Passing roughdielectric_through(Material m, float eta, float wo_h, float density, float seen, float shadowing) {
  float cos_t;
  const float passes = 1.0 - fresnel_dielectric(wo_h, eta, cos_t);
  // wo·h + eta wi·h, which would cancel where the indices are close; solid angle of h by that of wi is eta² |wi·h| over its square.
  const float sum = (1.0 - eta * eta) / (wo_h + eta * cos_t);
  float by_h = eta * eta * cos_t / (sum * sum);
  MUTATE(kMutantRefractionJacobian, by_h = cos_t / (sum * sum));
  Passing p;
  // Radiance shrinks by 1/eta².
  p.value = m.albedo * (passes * density * shadowing * wo_h * by_h / (eta * eta));
  MUTATE(kMutantRoughEtaOmitted, p.value *= eta * eta);
  p.pdf = passes * seen * wo_h * by_h;
  return p;
}
