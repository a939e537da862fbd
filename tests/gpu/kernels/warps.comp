#version 460
#extension GL_GOOGLE_include_directive : require
#include "warp.glsl"
#include "test_io.glsl"

TEST_BUFFERS(WarpCase, WarpAnswer)

vec3 warp(WarpCase c) {
  float r;
  switch (c.warp) {
    case kWarpDisk: return vec3(square_to_disk(c.u, r), 0.0);
    case kWarpCosineHemisphere: return square_to_cosine_hemisphere(c.u);
    case kWarpTriangle: return square_to_triangle(c.u);
    case kWarpCone: return square_to_cone(c.u, c.parameter);
    case kWarpOctant: return vec3(cos_sin_octant(c.u.x), 0.0);
    case kWarpTurn: return vec3(cos_sin_turn(c.u.x), 0.0);
  }
  return vec3(0.0);
}

void main() {
  if (!lane_has_work()) return;
  outputs[lane()] = WarpAnswer(warp(inputs[lane()]), 0u);
}
