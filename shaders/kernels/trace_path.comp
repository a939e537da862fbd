#version 460
#extension GL_GOOGLE_include_directive : require
#include "../integrator/trace_path.glsl"

layout(local_size_x = 1) in;

void main() { trace_requested_path(); }
