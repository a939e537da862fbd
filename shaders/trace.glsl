// BVH traversal: one function for closest and any hit.
#ifndef TRACE_GLSL
#define TRACE_GLSL

#include "intersect.glsl"

// Entry distance of the ray into a box, or +infinity when it misses it before t_max. The far distance is widened by the rounding of
// the products [Ize2013], so that a box never misses what it contains.
float intersect_box(vec3 lower, vec3 upper, vec3 o, vec3 inv_d, float t_max) {
  const vec3 t0 = (lower - o) * inv_d;
  const vec3 t1 = (upper - o) * inv_d;
  const vec3 near3 = min(t0, t1);
  const vec3 far3 = max(t0, t1);
  const float near = max(max(near3.x, near3.y), max(near3.z, 0.0));
  const float far = min(min(far3.x, far3.y), min(far3.z, t_max)) * (1.0 + 4e-7);
  return near <= far ? near : kInfinity;
}

// 1/d without infinities: a direction component of 0 becomes tiny, so that 0 · inf never makes a NaN in the slab test.
vec3 safe_inverse(vec3 d) {
  const vec3 tiny = vec3(1e-20);
  return 1.0 / mix(d, mix(-tiny, tiny, greaterThanEqual(d, vec3(0.0))), lessThan(abs(d), tiny));
}

// Finds the nearest hit in (t_min, t_max), or with any_hit the first one met. `steps` counts the nodes visited; the walk is cut off (and
// `steps` left above the budget) when it exceeds it, because some drivers end long loops silently.
Hit trace(Ray ray, bool any_hit, uint step_budget, inout uint steps) {
  Hit hit = Hit(ray.t_max, kNone, 0.0, 0.0);
  const RayFrame rf = make_ray_frame(ray);
  const vec3 inv_d = safe_inverse(ray.d);
  uint stack[kBvhMaxDepth + 2u];
  uint top = 0u;
  uint node_index = 0u;
  bool walking = true;
  // The exit is tested at the top as well: a loop that can only leave at its bottom loses lanes on some drivers.
  while (walking) {
    if (steps > step_budget) break;
    ++steps;
    const BvhNode node = fetch_node(node_index);
    bool descend = false;
    if (node.count > 0u) {
      for (uint i = 0u; i < node.count; ++i) {
        const bool found = intersect_primitive(rf, node.first + i, hit);
        if (found && any_hit) {
          walking = false;
          break;
        }
      }
    } else {
      const BvhNode left = fetch_node(node.first);
      const BvhNode right = fetch_node(node.first + 1u);
      const float t_left = intersect_box(left.lower, left.upper, ray.o, inv_d, hit.t);
      const float t_right = intersect_box(right.lower, right.upper, ray.o, inv_d, hit.t);
      const bool left_first = t_left <= t_right;
      const float t_near = min(t_left, t_right);
      if (t_near < kInfinity) {
        descend = true;
        node_index = left_first ? node.first : node.first + 1u;
        if (max(t_left, t_right) < kInfinity) stack[top++] = left_first ? node.first + 1u : node.first;
      }
    }
    if (walking && !descend) {
      if (top == 0u) {
        walking = false;
      } else {
        node_index = stack[--top];
      }
    }
  }
  return hit;
}

#endif
