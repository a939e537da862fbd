// Rough metal [Walter2007, eq. 20]: its microfacets reflect by Fresnel's equations; one-sided.
#include "../fresnel.glsl"
#include "../mutants.h"

vec3 roughconductor_reflectance(Material m, float wo_h) { return m.specular * fresnel_conductor(wo_h, m.eta, m.k); }
