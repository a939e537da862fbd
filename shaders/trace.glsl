// Tree traversal: one resumable walk for closest and any hit.
#ifndef TRACE_GLSL
#define TRACE_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "intersect.glsl"
#include "profile.glsl"

layout(constant_id = 8) const uint kStackSize = 16u;  // levels of the tree, so that the stack cannot overflow
layout(constant_id = 17) const uint kTreeRoot = 0u;   // record of the root; kNone for a scene without a tree

const bool kHasFew = kFewTriangles + kFewSpheres > 0u;
const uint kBeforeTree = 0xfffffffeu;

// A ray on its way through the scene: first the few primitives, then the tree. `current` is the record visited next, kBeforeTree while the few
// primitives are still to be tested, kNone when the walk has ended.
//
// A stack entry is one node's children still to be visited: its child base / 2 in the upper 24 bits, their number in bits 6–7 and
// their indices, nearest first, two bits each from bit 0. The top is walk_stack[0]; pushing shifts the whole array, which keeps it
// in registers: cheaper by far on lavapipe than an indexed array.
struct Walk {
  RayFrame rf;
  vec3 inv_d;
  Hit hit;
  uint current;
  bool any_hit;
};
// The one walk an invocation has at a time keeps its stack here: arrays sized by specialization constants cannot be copied with a struct.
uint walk_stack[kStackSize];

// 1/d without infinities: a direction component of 0 becomes tiny, so that 0 · inf never makes a NaN in the slab test.
vec3 safe_inverse(vec3 d) {
  const vec3 tiny = vec3(1e-20);
  return 1.0 / mix(d, mix(-tiny, tiny, greaterThanEqual(d, vec3(0.0))), lessThan(abs(d), tiny));
}

Walk begin_walk(Ray ray, bool any_hit) {
  Walk walk;
  walk.rf = make_ray_frame(ray);
  walk.inv_d = safe_inverse(ray.d);
  walk.hit = Hit(ray.t_max, kNone, 0.0, 0.0);
  // A ray that is no ray would meet every box of the tree, or none, as the driver's min and max please: it misses.
  walk.current = is_finite(ray.o + ray.d) ? (kHasFew ? kBeforeTree : kTreeRoot) : kNone;
  walk.any_hit = any_hit;
  walk_stack[0] = 0u;  // an entry without children ends the walk; what lies below is never reached
  return walk;
}

const uint kMissKey = 0xffffffffu;

vec4 unpack_bytes(uint v) { return vec4(v & 0xffu, (v >> 8u) & 0xffu, (v >> 16u) & 0xffu, v >> 24u); }

// Sort keys of a node's children: the bits of the entry distance (non-negative floats order like integers) with the child's index in the
// lowest two, or kMissKey.
uvec4 child_keys(Walk walk, Record node) {
  const vec3 scale = uintBitsToFloat(uvec3(node.a.w << 23u, (node.a.w << 15u) & 0x7f800000u, (node.a.w << 7u) & 0x7f800000u) & 0x7f800000u);
  const vec3 a = scale * walk.inv_d;
  const vec3 b = (uintBitsToFloat(node.a.xyz) - walk.rf.ray.o) * walk.inv_d;
  // Rounding must not lose a box: near planes move back and far planes forward by more than the error of b, and the far distance
  // is scaled by more than that of the sum below [Ize2013].
  const vec3 margin = abs(b) * 3e-7;
  const vec3 b_near = b - margin;
  const vec3 b_far = b + margin;
  const bvec3 forward = greaterThanEqual(walk.inv_d, vec3(0.0));
  const uvec3 q_near = mix(node.c.xyz, node.b.xyz, forward);
  const uvec3 q_far = mix(node.b.xyz, node.c.xyz, forward);
  // Compared as integers, which order floats that are not negative alike and take one instruction where floats take three for the sake of NaNs.
  // Negative distances come out in the wrong order among themselves but below all others, and that is all that is asked here.
  const ivec4 near = max(max(floatBitsToInt(unpack_bytes(q_near.x) * a.x + b_near.x), floatBitsToInt(unpack_bytes(q_near.y) * a.y + b_near.y)),
                         max(floatBitsToInt(unpack_bytes(q_near.z) * a.z + b_near.z), ivec4(0)));
  const ivec4 far_exact = min(min(floatBitsToInt(unpack_bytes(q_far.x) * a.x + b_far.x), floatBitsToInt(unpack_bytes(q_far.y) * a.y + b_far.y)),
                              min(floatBitsToInt(unpack_bytes(q_far.z) * a.z + b_far.z), ivec4(floatBitsToInt(walk.hit.t))));
  const ivec4 far = floatBitsToInt(intBitsToFloat(far_exact) * (1.0 + 1e-6));
  const uint count = (node.a.w >> kRecordChildCountShift) & 7u;
  const uvec4 index = uvec4(0u, 1u, 2u, 3u);
  const uvec4 keys = (uvec4(near) & 0xfffffffcu) | index;
  // Children 2 and 3 may be missing; their boxes are empty, but a flat node could still let a ray through.
  return uvec4(near.x <= far.x ? keys.x : kMissKey, near.y <= far.y ? keys.y : kMissKey,
               near.z <= far.z && count > 2u ? keys.z : kMissKey, near.w <= far.w && count > 3u ? keys.w : kMissKey);
}

// Ascending, five comparators.
uvec4 sort_keys(uvec4 k) {
  k = uvec4(min(k.x, k.y), max(k.x, k.y), min(k.z, k.w), max(k.z, k.w));
  k = uvec4(min(k.x, k.z), min(k.y, k.w), max(k.x, k.z), max(k.y, k.w));
  return uvec4(k.x, min(k.y, k.z), max(k.y, k.z), k.w);
}

// The step before the tree, for walks that have not taken it: the primitives that most rays would meet there anyhow.
void test_few_primitives(inout Walk walk) {
  if (!kHasFew || walk.current != kBeforeTree) return;
  PROFILE(profile_step(0u, kFewTriangles + kFewSpheres));
  walk.hit = intersect_few_primitives(walk.rf);
  walk.current = walk.any_hit && walk.hit.slot != kNone ? kNone : kTreeRoot;
}

// Visits one record: a node sends the walk to its nearest child and stacks the others, a primitive is intersected.
void walk_step(inout Walk walk) {
  if (kTreeRoot == kNone) return;
  const Record record = fetch_record(walk.current);
  const bool node = (record.a.w & kRecordNode) != 0u;
  PROFILE(profile_step(node ? 1u : 0u, node ? 0u : 1u));

  const uvec4 keys = sort_keys(child_keys(walk, record));
  const uint hits = node ? uint(keys.x != kMissKey) + uint(keys.y != kMissKey) + uint(keys.z != kMissKey) + uint(keys.w != kMissKey) : 0u;
  const bool found = !node && intersect_primitive(walk.rf, record, walk.current, walk.hit);

  const bool push = hits > 1u;
  const bool pop = hits == 0u;
  const uint top = walk_stack[0];
  const uint left = (top >> 6u) & 3u;
  // The entry below the new top: the rest of the node's children, or the top without the child that is taken now.
  const uint pushed = (record.b.w << 7u) | ((hits - 1u) << 6u) | (keys.y & 3u) | ((keys.z & 3u) << 2u) | ((keys.w & 3u) << 4u);
  const uint taken = (top & 0xffffff00u) | ((left - 1u) << 6u) | ((top & 0x3fu) >> 2u);
  const bool drop = pop && left <= 1u;
  const uint next = pop ? ((top >> 7u) & 0x1fffffeu) + (top & 3u) : record.b.w + (keys.x & 3u);
  uint below = 0u;
  // A signed counter: lavapipe does not unroll a loop that counts an unsigned one down, and then the stack lies in memory.
  [[unroll]] for (int i = int(kStackSize) - 1; i > 0; --i) {
    const uint here = walk_stack[i];
    walk_stack[i] = push ? walk_stack[i - 1] : drop ? below : here;
    below = here;
  }
  walk_stack[0] = push ? pushed : drop ? below : pop ? taken : top;
  walk.current = (pop && left == 0u) || (found && walk.any_hit) ? kNone : next;
}

// Walks to the end, or until `steps` exceeds the budget: some drivers end long loops silently. The few primitives together are one step.
Hit trace(Ray ray, bool any_hit, uint step_budget, inout uint steps) {
  Walk walk = begin_walk(ray, any_hit);
  test_few_primitives(walk);
  if (kHasFew) ++steps;
  // The exit is tested at the top as well: a loop that can only leave at its bottom loses lanes on some drivers.
  while (walk.current != kNone) {
    if (steps > step_budget) break;
    ++steps;
    walk_step(walk);
  }
  return walk.hit;
}

#endif
