// Rays through the scene: one resumable walk for closest and any hit. Other files may use only begin_walk, advance_walk, walk_done and walk_hit;
// addresses within the tree stay in this file. In kernels built with ETENDUE_RAY_QUERY the driver traverses instead, see trace_query.glsl.
#ifndef TRACE_GLSL
#define TRACE_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "intersect.glsl"
#include "profile.glsl"
#include "surface.glsl"

// Levels of the tree, so that the stack cannot overflow; if meshes are shared, plus those of the deepest.
layout(constant_id = kConstantStackSize) const uint kStackSize = 16u;
layout(constant_id = kConstantTreeRoot) const uint kTreeRoot = 0u;   // slot of the root; kNone for a scene without a tree

const bool kHasFew = kFewCount > 0u;
const uint kBeforeTree = 0xfffffffeu;

#ifdef ETENDUE_RAY_QUERY
#include "trace_query.glsl"
#else

// A ray on its way through the scene: first the few primitives, then the tree. `current` is the slot visited next, kBeforeTree while the few
// primitives are still to be tested, kNone when the walk has ended.
struct Walk {
  RayFrame rf;
  vec3 inv_d;
  Nearest nearest;
  uint current;
  bool any_hit;
  Passed passed;
  // If meshes are shared: the instance whose mesh's tree the walk is in, or kNone in the world, and the ray in the world. Inside, rf and inv_d are
  // those of the ray in the mesh's space, and the upper `inner` entries of the stack are of the mesh's tree.
  uint instance;
  uint inner;
  vec3 world_o, world_d;
};

// 1/d without infinities: a direction component of 0 becomes tiny, so that 0 · inf never makes a NaN in the slab test.
vec3 safe_inverse(vec3 d) {
  const vec3 tiny = vec3(1e-20);
  return 1.0 / mix(d, mix(-tiny, tiny, greaterThanEqual(d, vec3(0.0))), lessThan(abs(d), tiny));
}

// The layout of the tree's nodes, and how the walk remembers children that it has not visited yet.
#if ETENDUE_BVH_WIDTH == 8
#include "node8.glsl"
#else
#include "node4.glsl"
#endif

// The one walk an invocation has at a time keeps its stack here: arrays sized by specialization constants cannot be copied with a struct. The top is
// walk_stack[0]; pushing shifts the whole array, which keeps it in registers: cheaper by far on lavapipe than an indexed array.
StackEntry walk_stack[kStackSize];

Walk begin_walk(Ray ray, bool any_hit, Passed passed) {
  Walk walk;
  walk.rf = make_ray_frame(ray);
  walk.inv_d = safe_inverse(ray.d);
  walk.nearest = Nearest(ray.t_max, kNone, 0u, 0u);
  // A non-finite ray misses. Without this test the result would depend on the driver's min/max: it would hit every box of the tree, or none.
  walk.current = is_finite(ray.o + ray.d) ? (kHasFew ? kBeforeTree : kTreeRoot) : kNone;
  walk.any_hit = any_hit;
  walk.passed = passed;
  walk.instance = kNone;
  walk.inner = 0u;
  walk.world_o = ray.o;
  walk.world_d = ray.d;
  walk_stack[0] = StackEntry(0u);  // an entry without children ends the walk; entries below it are never reached
  return walk;
}

#endif

// True once the walk has ended. An any-hit walk ends at the first hit that no light passes.
bool walk_done(Walk walk) { return walk.current == kNone; }
// Whether anything was hit: the only result of an any-hit walk.
bool walk_found(Walk walk) { return walk.nearest.slot != kNone; }

// The result of a closest-hit walk.
Hit walk_hit(Walk walk) {
  const Primitive prim = to_primitive(fetch_record(walk_found(walk) ? walk.nearest.slot : 0u));
#ifdef ETENDUE_RAY_QUERY
  return far_hit(walk, prim);
#else
  if (kInstanced) return make_shared_hit(walk.rf.ray, walk.nearest.t, walk_found(walk), walk.nearest.instance, prim);
  return make_hit(walk.rf.ray, walk.nearest.t, walk_found(walk), prim);
#endif
}

// The step before the tree, for walks that have not taken it yet: tests the few primitives, which most rays would meet
// in the tree anyway.
void test_few_primitives(inout Walk walk) {
  if (!kHasFew || walk.current != kBeforeTree) return;
  PROFILE(profile_step(0u, kFewCount));
  walk.nearest = intersect_few_primitives(walk.rf, walk.passed);
  if ((kTreeRoot != kNone || kPassable) && walk_found(walk)) walk.nearest.order = fetch_record(walk.nearest.slot).c.w;
  if (kInstanced && walk_found(walk)) walk.nearest.instance = fetch_record(walk.nearest.slot).a.w;
  walk.current = walk.any_hit && walk_found(walk) && is_opaque(walk.nearest.order) ? kNone : kTreeRoot;
}

#ifndef ETENDUE_RAY_QUERY

// Turns a ray that has reached an instance's record toward the tree of its mesh, or one that is done with a mesh back to the world.
void cross_border(inout Walk walk, Record record, bool enters) {
  // lavapipe computes this for all lanes. The bits of other records would often be denormal numbers, which processors multiply a hundred times slower.
  const uvec3 mask = uvec3(enters ? 0xffffffffu : 0u);
  const vec3 r0 = uintBitsToFloat(record.a.xyz & mask), r1 = uintBitsToFloat(record.b.xyz & mask), r2 = uintBitsToFloat(record.c.xyz & mask);
  vec3 o = walk.world_o, unit = walk.world_d;
  float size = 1.0;
  if (enters) {
    o = to_place(r0, r1, r2, walk.world_o - fetch_place_origin(record.c.w));
    const vec3 d = to_place(r0, r1, r2, walk.world_d);
    size = length(d);
    unit = unit_of(d, size);
  }
  RayFrame rf = make_scaled_frame(Ray(o, walk.rf.ray.t_min, unit, walk.rf.ray.t_max), size);
  MUTATE(kMutantInstanceNotLeft, if (!enters) rf = walk.rf);
  walk.rf = rf;
  walk.inv_d = safe_inverse(unit) / size;
  walk.instance = enters ? record.a.w & ~kRecordInstance : kNone;
  walk.inner = 0u;
}

// Visits one record: a node sends the walk to its nearest child and stacks the others, a primitive is intersected.
void walk_step(inout Walk walk) {
  if (kTreeRoot == kNone) return;
  const Record record = fetch_record(walk.current);
  const bool node = (record.a.w & kRecordNode) != 0u;
  const bool enter = kInstanced && !node && (record.a.w & kRecordInstance) != 0u;
  PROFILE(profile_step(node ? 1u : 0u, node ? 0u : 1u));

  const NodeVisit visit = visit_node(walk, record);
  const uint hits = node ? visit.hits : 0u;
  const uint instance = kInstanced && walk.instance != kNone ? walk.instance : record.a.w;
  const bool found = !node && !enter && intersect_primitive(walk.rf, record, walk.current, instance, walk.passed, walk.nearest);

  const bool push = hits > 1u;
  const bool pop = hits == 0u && !enter;
  // The entries below those of the mesh are of the world.
  const bool leave = kInstanced && pop && walk.instance != kNone && walk.inner == 0u;
  const StackEntry top = walk_stack[0];
  const uint left = children_left(top);
  const bool drop = pop && left <= 1u;
  const uint next = pop ? next_child(top) : enter ? record.b.w : visit.nearest;
  // The entry below the new top: the remaining children of the node, or the top without the child that is taken now.
  const StackEntry taken = without_next(top);
  StackEntry below = StackEntry(0u);
  // A signed counter: lavapipe does not unroll a loop that counts an unsigned one down, and then keeps the stack in memory.
  [[unroll]] for (int i = int(kStackSize) - 1; i > 0; --i) {
    const StackEntry here = walk_stack[i];
    walk_stack[i] = push ? walk_stack[i - 1] : drop ? below : here;
    below = here;
  }
  walk_stack[0] = push ? visit.others : drop ? below : pop ? taken : top;
  walk.current = (pop && left == 0u) || (found && walk.any_hit && is_opaque(walk.nearest.order)) ? kNone : next;
  if (kInstanced) {
    walk.inner += uint(push) - uint(drop);
    if (enter || leave) cross_border(walk, record, enter);
  }
}

#endif

// Visits up to `steps` records, after the few primitives if they have not been tested.
void advance_walk(inout Walk walk, uint steps) {
  test_few_primitives(walk);
  for (uint i = 0u; i < steps; ++i) {
    if (walk_done(walk)) break;
    walk_step(walk);
  }
}

// Walks to the end, or until `steps` exceeds the budget: some drivers end long loops silently. The few primitives together are one step.
Walk trace(Ray ray, bool any_hit, Passed passed, uint step_budget, inout uint steps) {
  Walk walk = begin_walk(ray, any_hit, passed);
  test_few_primitives(walk);
  if (kHasFew) ++steps;
  // The exit is also tested at the top: a loop that can be left only at its bottom loses lanes on some drivers.
  while (!walk_done(walk)) {
    if (steps > step_budget) break;
    ++steps;
    walk_step(walk);
  }
  return walk;
}
Walk trace(Ray ray, bool any_hit, uint step_budget, inout uint steps) { return trace(ray, any_hit, kNothingPassed, step_budget, steps); }

#endif
