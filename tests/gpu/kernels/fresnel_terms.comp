#version 460
#extension GL_GOOGLE_include_directive : require
#include "fresnel.glsl"
#include "test_io.glsl"

TEST_BUFFERS(FresnelCase, FresnelAnswer)

void main() {
  if (!lane_has_work()) return;
  const FresnelCase c = inputs[lane()];
  float cos_t;
  const float reflectance = fresnel_dielectric(c.cos_o, c.eta, cos_t);
  outputs[lane()] = FresnelAnswer(reflectance, cos_t, 0u, 0u);
}
