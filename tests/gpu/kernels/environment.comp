#version 460
#extension GL_GOOGLE_include_directive : require
#include "sampler.glsl"
#include "emitter/emitter.glsl"
#include "test_io.glsl"

TEST_BUFFERS(EnvironmentCase, EnvironmentAnswer)

void main() {
  if (!lane_has_work()) return;
  const EnvironmentCase c = inputs[lane()];
  EnvironmentAnswer a;
  a.chosen = chooses_environment(c.words) ? 1u : 0u;
  const LightSample s = sample_environment(c.words);
  a.wi = s.wi;
  a.pdf_w = s.pdf_w;
  a.radiance = s.radiance;
  if (kEnvironmentPictured) a.radiance *= picture_radiance(s.sky);
  a.cell = s.primitive;
  EnvironmentPlace at;
  a.seen = environment_radiance(c.w, at, a.seen_pdf_w);
  if (kEnvironmentPictured) a.seen *= picture_radiance(at);
  a.pad0 = a.pad1 = a.pad2 = 0u;
  outputs[lane()] = a;
}
