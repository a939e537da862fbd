// Nearest hit by testing every primitive: what the tree must find, with the same intersection functions.
//
// Primitives do not lie at regular distances in every layout of the tree, so the test lists their slots: list_primitives in device_test.h.
#ifndef BRUTE_FORCE_GLSL
#define BRUTE_FORCE_GLSL

#include "surface.glsl"
#include "test_types.h"

uint listed_count() { return uint(textureSize(geometry_texels)); }

// Tests the i-th listed primitive.
bool intersect_listed(RayFrame rf, uint i, inout Nearest nearest) {
  const uvec4 entry = load_geometry(i);
  if (entry.w != kListed) return false;  // vertex normals, an attribute, or the one texel of an empty buffer
  return intersect_primitive(rf, fetch_record(entry.x), entry.x, fetch_record(entry.x).a.w, kNothingPassed, nearest);
}

Hit trace_brute_force(Ray ray) {
  const RayFrame rf = make_ray_frame(ray);
  Nearest nearest = Nearest(ray.t_max, kNone, 0u, 0u);
  for (uint i = 0u; i < listed_count(); ++i) intersect_listed(rf, i, nearest);
  const bool found = nearest.slot != kNone;
  return make_hit(ray, nearest.t, found, to_primitive(fetch_record(found ? nearest.slot : 0u)));
}

// Primitives that lie at exactly distance t: among them the choice is free.
uint count_ties(Ray ray, float t) {
  const RayFrame rf = make_ray_frame(ray);
  uint ties = 0u;
  for (uint i = 0u; i < listed_count(); ++i) {
    Nearest nearest = Nearest(ray.t_max, kNone, 0u, 0u);
    if (intersect_listed(rf, i, nearest) && nearest.t == t) ++ties;
  }
  return ties;
}

#endif
