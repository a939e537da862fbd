// Rough boundary between two clear media [Walter2007]: its microfacets reflect and refract by Fresnel's equations. wo
// is on the side z > 0 here; eta is n_i/n_o for transmission.
#include "../fresnel.glsl"
#include "../mutants.h"

// Light transmitted by microfacets of normal h. `seen` is the density of normals visible from wo, `shadowing` the
// masking of both directions divided by the cosine of wo.
struct Passing {
  vec3 value;
  float pdf;
};

Passing roughdielectric_through(Material m, float eta, float wo_h, float density, float seen, float shadowing) {
  float cos_t;
  const float passes = 1.0 - fresnel_dielectric(wo_h, eta, cos_t);
  // wo·h + eta wi·h, written so that nothing cancels if the indices are close; dω_h/dω_i is eta² |wi·h| divided by its
  // square.
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
