// Traversal by the driver: ray queries through acceleration structures, in place of Etendue's tree. Part of trace.glsl.
//
// The driver sees boxes, never triangles: it reports primitives whose boxes the ray meets, and the tests of
// intersect.glsl decide, as in the tree. Hits are therefore identical to those of the tree, including ties and masks,
// and closed surfaces are just as tight. The driver's own test of triangles rounds differently, and near an edge, where
// two tests may choose different triangles, rays would be lost. Boxes are widened (compile/query_scene.h) by more than
// a driver's rounding may move a ray that begins within kNearOrigin of the scene's centre; for other rays, the query
// begins there.
#ifndef TRACE_QUERY_GLSL
#define TRACE_QUERY_GLSL

const float kNearOrigin = 8.0;       // the scene is within 1 of the centre along each axis
const uint kQuerying = 0xfffffffdu;  // a value of Walk::current

// A ray on its way: first the few primitives, then the driver's candidates one by one. `current` is kBeforeTree while the few are still to be tested,
// kTreeRoot while the driver is still to be asked, kQuerying while it answers, kNone when the walk has ended.
struct Walk {
  RayFrame rf;  // in the world, from `skipped` on; until the walk has ended, distances are measured from there
  Nearest nearest;
  uint current;
  bool any_hit;
  Passed passed;
  float skipped;
  float t_min, reach;  // the interval passed to the driver
  // If meshes are shared: the record of the instance in whose space `inner` is, and the ray in that space.
  uint instance_slot;
  RayFrame inner;
};

// The one query an invocation has at a time: queries cannot be copied with a struct.
rayQueryEXT walk_query;

// The direction without zero components, because a driver may multiply their inverse by 0.
vec3 without_zeros(vec3 d) {
  const vec3 tiny = vec3(1e-20);
  return mix(d, mix(-tiny, tiny, greaterThanEqual(d, vec3(0.0))), lessThan(abs(d), tiny));
}

Walk begin_walk(Ray ray, bool any_hit, Passed passed) {
  Walk walk;
  walk.skipped = max(0.0, length(ray.o) - kNearOrigin);
  if (walk.skipped > 0.0) {
    ray.o += walk.skipped * ray.d;
    ray.t_min = max(0.0, ray.t_min - walk.skipped);
    ray.t_max -= walk.skipped;
    passed.t_own -= walk.skipped;
  }
  walk.rf = make_ray_frame(ray);
  walk.nearest = Nearest(ray.t_max, kNone, 0u, 0u);
  // A non-finite ray misses.
  walk.current = is_finite(ray.o + ray.d) && ray.t_max > 0.0 ? (kHasFew ? kBeforeTree : kTreeRoot) : kNone;
  walk.any_hit = any_hit;
  walk.passed = passed;
  walk.instance_slot = kNone;
  walk.inner = walk.rf;
  walk.t_min = 0.0;
  walk.reach = 0.0;
  return walk;
}

void start_query(inout Walk walk) {
  const Ray ray = walk.rf.ray;
  // Slightly before t_min, so that surfaces at t_min itself are found, see Passed.
  walk.t_min = ray.t_min * (1.0 - 1e-6);
  walk.reach = max(walk.t_min, min(walk.nearest.t, 3.0e38));
  rayQueryInitializeEXT(walk_query, scene_structure, gl_RayFlagsNoneEXT, 0xffu, ray.o, walk.t_min, without_zeros(ray.d), walk.reach);
  walk.current = kQuerying;
}

// The ray in the space of the mesh named by the instance's record.
void enter_space(inout Walk walk, uint slot, Record record) {
  const vec3 r0 = uintBitsToFloat(record.a.xyz), r1 = uintBitsToFloat(record.b.xyz), r2 = uintBitsToFloat(record.c.xyz);
  const vec3 o = to_place(r0, r1, r2, walk.rf.ray.o - fetch_place_origin(record.c.w));
  const vec3 d = to_place(r0, r1, r2, walk.rf.ray.d);
  walk.inner = make_scaled_ray(Ray(o, walk.rf.ray.t_min, d, walk.rf.ray.t_max)).rf;
  walk.instance_slot = slot;
}

// Tests the driver's next candidate, or ends the walk if there is none.
void walk_step(inout Walk walk) {
  if (kTreeRoot == kNone) return;
  if (walk.current == kTreeRoot) start_query(walk);
  if (!rayQueryProceedEXT(walk_query)) {
    walk.current = kNone;
    return;
  }
  const uint named = uint(rayQueryGetIntersectionInstanceCustomIndexEXT(walk_query, false));
  const bool shared_mesh = kInstanced && named != kQueryWorld;
  uint first = kFewCount * kPrimitiveSlots, instance = 0u;
  if (shared_mesh) {
    const uint slot = kTreeRoot + named * kPrimitiveSlots;
    const Record placed = fetch_record(slot);
    if (slot != walk.instance_slot) enter_space(walk, slot, placed);
    first = placed.b.w;
    instance = placed.a.w & ~kRecordInstance;
  }
  const uint slot = first + uint(rayQueryGetIntersectionPrimitiveIndexEXT(walk_query, false)) * kPrimitiveSlots;
  const Record record = fetch_record(slot);
  RayFrame rf = walk.rf;
  if (shared_mesh) rf = walk.inner;
  if (!intersect_primitive(rf, record, slot, shared_mesh ? instance : record.a.w, walk.passed, walk.nearest)) return;
  // Clamped to the interval that the driver was given, as it requires.
  walk.reach = clamp(walk.nearest.t, walk.t_min, walk.reach);
  rayQueryGenerateIntersectionEXT(walk_query, walk.reach);
  if (walk.any_hit && is_opaque(walk.nearest.order)) walk.current = kNone;
}

// The hit, with its distance from the true origin of the ray.
Hit far_hit(Walk walk, Primitive prim) {
  const bool found = walk.nearest.slot != kNone;
  Hit hit = make_hit(walk.rf.ray, walk.nearest.t, found, prim);
  if (kInstanced) hit = make_shared_hit(walk.rf.ray, walk.nearest.t, found, walk.nearest.instance, prim);
  hit.t += walk.skipped;
  return hit;
}

#endif
