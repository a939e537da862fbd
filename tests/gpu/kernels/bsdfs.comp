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
  outputs[lane()] = BsdfAnswer(s.wi, s.pdf, s.weight, s.lobe, bsdf_eval(m, c.wo, s.wi), bsdf_pdf(m, c.wo, s.wi), bsdf_eval(m, c.wo, c.wi),
                               bsdf_pdf(m, c.wo, c.wi), s.eta_scale, material_has(m, kMaterialDelta) ? 1u : 0u, material_has(m, kMaterialOneSided) ? 1u : 0u, 0u);
}
