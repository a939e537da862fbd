#version 460
#extension GL_GOOGLE_include_directive : require
#include "sampler.glsl"
#include "emitter/emitter.glsl"
#include "test_io.glsl"

TEST_BUFFERS(LightCase, LightAnswer)

void main() {
  if (!lane_has_work()) return;
  const LightCase c = inputs[lane()];
  const LightSample s = sample_light(c.p, c.n, c.words);
  outputs[lane()] = LightAnswer(s.p, s.pdf_w, s.wi, s.mis_pdf, s.ng, s.error, s.radiance, s.instance, s.primitive, 0u, 0u, 0u);
}
