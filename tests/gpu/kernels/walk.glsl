// The one place where the test kernels meet the traversal: nearest hit and any hit without a budget.
#ifndef WALK_GLSL
#define WALK_GLSL

#include "trace.glsl"

Walk walk(Ray ray, bool any_hit) {
  uint steps = 0u;
  return trace(ray, any_hit, 60000u, steps);
}

#endif
