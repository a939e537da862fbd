#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "test_io.glsl"

TEST_BUFFERS(FrameCase, FrameAnswer)

void main() {
  if (!lane_has_work()) return;
  const FrameCase c = inputs[lane()];
  const ShadingFrame f = make_frame(c.n);
  const vec3 local = to_local(f, c.w);
  outputs[lane()] = FrameAnswer(f.s, 0u, f.t, 0u, local, 0u, to_world(f, local), 0u);
}
