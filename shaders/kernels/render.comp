#version 460
#extension GL_GOOGLE_include_directive : require
#include "../integrator/render_lane.glsl"

layout(local_size_x = kWorkgroupSize) in;

void main() { render_lane(gl_WorkGroupID.x, gl_LocalInvocationIndex); }
