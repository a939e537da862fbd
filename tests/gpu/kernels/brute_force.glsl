// Nearest hit by testing every primitive record: what the tree must find, with the same intersection functions.
#ifndef BRUTE_FORCE_GLSL
#define BRUTE_FORCE_GLSL

#include "intersect.glsl"

uint record_count() { return uint(textureSize(record_texels)) / 3u; }

Hit trace_brute_force(Ray ray) {
  const RayFrame rf = make_ray_frame(ray);
  Hit hit = Hit(ray.t_max, kNone, 0.0, 0.0);
  for (uint slot = 0u; slot < record_count(); ++slot) {
    const Record record = fetch_record(slot);
    if ((record.a.w & kRecordNode) == 0u) intersect_primitive(rf, record, slot, hit);
  }
  return hit;
}

// Primitives that lie at exactly distance t: among them the choice is free.
uint count_ties(Ray ray, float t) {
  const RayFrame rf = make_ray_frame(ray);
  uint ties = 0u;
  for (uint slot = 0u; slot < record_count(); ++slot) {
    const Record record = fetch_record(slot);
    Hit hit = Hit(ray.t_max, kNone, 0.0, 0.0);
    if ((record.a.w & kRecordNode) == 0u && intersect_primitive(rf, record, slot, hit) && hit.t == t) ++ties;
  }
  return ties;
}

#endif
