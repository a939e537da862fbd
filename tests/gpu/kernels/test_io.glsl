// Input and output of the test kernels: lane i maps inputs[i] to outputs[i].
#ifndef TEST_IO_GLSL
#define TEST_IO_GLSL

#include "test_types.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform PassBlock { Pass pass; };

#define TEST_BUFFERS(Input, Output)                                                                         \
  layout(set = kSetKernel, binding = kBindingRequests, std430) readonly buffer InputBuffer { Input inputs[]; };     \
  layout(set = kSetKernel, binding = kBindingResults, std430) writeonly buffer OutputBuffer { Output outputs[]; };

uint lane() { return gl_GlobalInvocationID.x; }
bool lane_has_work() { return lane() < pass.request_count; }

#endif
