// A diffuse base inside a rough clear coat: the transmittance of the coat's microfacets comes from a table.
#include "../fresnel.glsl"
#include "../scene.glsl"

vec3 roughplastic_reflectance(Material m, float wo_h) {
  float cos_t;
  return m.specular * fresnel_dielectric(wo_h, m.int_ior / m.ext_ior, cos_t);
}

float coat_passes(uint first, float cosine) {
  const float x = min(cosine, 1.0) * float(kTransmittanceNodes - 1u);
  const uint node = min(uint(x), kTransmittanceNodes - 2u);
  const float a = fetch_transmittances(first + node / 4u)[node % 4u];
  const float b = fetch_transmittances(first + (node + 1u) / 4u)[(node + 1u) % 4u];
  return mix(a, b, x - float(node));
}

// The fraction of light from a direction of this cosine that enters through the coat: linear between the nodes, and
// between two roughnesses if the roughness varies.
float roughplastic_passes(Material m, float cosine) {
  const uint first = uint(m.k.z);
  const float passes = coat_passes(first, cosine);
  if (!textures_have(kTexturesCoat) || m.eta.z == 0.0) return passes;
  return mix(passes, coat_passes(first + kCoatTexels, cosine), m.eta.z);
}

// For a coat of varying roughness: the table of the next lower roughness, and in eta.z the fraction of the way to the
// one above.
void resolve_coat(inout Material m) {
  const float x = sqrt(m.alpha.x) * float(kCoatRoughnesses - 1u);
  const uint row = min(uint(x), kCoatRoughnesses - 2u);
  m.eta.z = x - float(row);
  const uint first = uint(m.k.z) + row * kCoatTexels;
  m.k.z = float(first);
  m.k.x = mix(fetch_transmittances(first + kCoatTexels - 1u).x, fetch_transmittances(first + 2u * kCoatTexels - 1u).x, m.eta.z);
  MUTATE(kMutantCoatInsideForgotten, m.k.x = 0.0);
}
