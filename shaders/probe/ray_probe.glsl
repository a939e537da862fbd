// Single rays: the walk of the tree without shading, to measure it and to compare its hits with those of other
// implementations.
#ifndef RAY_PROBE_GLSL
#define RAY_PROBE_GLSL

#include "../trace.glsl"

layout(constant_id = kConstantAnyHit) const bool kAnyHit = false;  // any hit ends the walk, as it does for shadow rays

layout(push_constant) uniform PassBlock { Pass pass; };
layout(set = kSetKernel, binding = kBindingRequests, std430) readonly buffer RayBuffer { RayRequest rays[]; };
layout(set = kSetKernel, binding = kBindingResults, std430) writeonly buffer ResultBuffer { RayResult results[]; };

// One ray per lane. The number of steps shows whether a walk has exceeded the budget.
void cast_ray(uint i) {
  if (i >= pass.request_count) return;
  const RayRequest request = rays[i];
  uint steps = 0u;
  const Hit hit = walk_hit(trace(Ray(request.o, request.t_min, request.d, request.t_max), kAnyHit, pass.step_budget, steps));
  results[i] = RayResult(hit.t, hit.instance, hit.primitive, steps);
}

#endif
