#version 460
#extension GL_GOOGLE_include_directive : require
#include "../probe/ray_probe.glsl"

layout(local_size_x = kWorkgroupSize) in;

void main() { cast_ray(gl_GlobalInvocationID.x); }
