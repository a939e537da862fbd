#version 460
#extension GL_GOOGLE_include_directive : require
// The first texture of the scene at points of its surfaces.
#include "test_io.glsl"
#include "texture.glsl"

TEST_BUFFERS(TextureCase, TextureAnswer)

void main() {
  if (!lane_has_work()) return;
  const TextureCase c = inputs[lane()];
  outputs[lane()] = TextureAnswer(texture_value(0u, SurfacePoint(c.instance, c.primitive, c.weights, c.n)));
}
