#version 460
#extension GL_GOOGLE_include_directive : require
#include "../integrator/trace_samples.glsl"

layout(local_size_x = kWorkgroupSize) in;

void main() { trace_sample(gl_GlobalInvocationID.x); }
