// A diffuse base inside a rough clear coat: what the coat's microfacets let pass comes from a table.
#include "../fresnel.glsl"
#include "../scene.glsl"

vec3 roughplastic_reflectance(Material m, float wo_h) {
  float cos_t;
  return m.specular * fresnel_dielectric(wo_h, m.int_ior / m.ext_ior, cos_t);
}

// What enters through the coat from a direction of this cosine: linear between the nodes.
float roughplastic_passes(Material m, float cosine) {
  const float x = min(cosine, 1.0) * float(kTransmittanceNodes - 1u);
  const uint node = min(uint(x), kTransmittanceNodes - 2u);
  const uint first = uint(m.k.z);
  const float a = fetch_transmittances(first + node / 4u)[node % 4u];
  const float b = fetch_transmittances(first + (node + 1u) / 4u)[(node + 1u) % 4u];
  return mix(a, b, x - float(node));
}
