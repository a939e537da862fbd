#version 460
#extension GL_GOOGLE_include_directive : require
#include "../probe/bsdf_probe.glsl"

layout(local_size_x = kWorkgroupSize) in;

void main() { probe_bsdf(gl_GlobalInvocationID.x); }
