#version 460
#extension GL_GOOGLE_include_directive : require
#include "bsdf/bsdf.glsl"
#include "test_io.glsl"

TEST_BUFFERS(BsdfCase, BsdfAnswer)

void main() {
  if (!lane_has_work()) return;
  const BsdfCase c = inputs[lane()];
  Material m = plain_material(c.header, c.albedo);
  m.int_ior = c.int_ior;
  m.ext_ior = c.ext_ior;
  const BsdfSample s = bsdf_sample(m, c.wo, c.u_lobe, c.u);
  const Scattering sampled = bsdf_evaluate(m, c.wo, s.wi), asked = bsdf_evaluate(m, c.wo, c.wi);
  outputs[lane()] = BsdfAnswer(s.wi, s.pdf, s.weight, s.lobe, sampled.value, sampled.pdf, asked.value, asked.pdf, s.eta_scale, material_has(m, kMaterialDelta) ? 1u : 0u, material_has(m, kMaterialOneSided) ? 1u : 0u, 0u);
}
