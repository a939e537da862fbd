// Nodes with up to eight children: their boxes against a ray, and the walk's memory of them. See kNode8* in gpu_types.h.
#ifndef NODE8_GLSL
#define NODE8_GLSL

#include "slabs.glsl"

// A node's children still to be visited. x: the node's a.w without its count, which gives the position of its children; y: their number from bit 21
// on and their indices, nearest first, three bits each from bit 0.
#define StackEntry uvec2

// The slot of a node's child, from the node's a.w.
uint child_slot(uint place, uint child) {
  const uint inner = (place >> kNode8InnerShift) & 7u;
  return 4u * (place & kNode8BaseMask) + 3u * child + min(child, inner);
}

uint children_left(StackEntry e) { return e.y >> 21u; }
uint next_child(StackEntry e) { return child_slot(e.x, e.y & 7u); }
StackEntry without_next(StackEntry e) { return StackEntry(e.x, ((children_left(e) - 1u) << 21u) | ((e.y & 0x1fffffu) >> 3u)); }

// The children of a node that a ray hits: their number, the slot of the nearest and, if there are more, the entry of the others.
struct NodeVisit {
  uint hits;
  uint nearest;
  StackEntry others;
};

// Keys of children 0–3 and 4–7.
struct ChildKeys {
  uvec4 low, high;
};

ChildKeys child_keys(Walk walk, Record node, uvec4 planes_z) {
  const vec3 origin = vec3(ivec3(node.a.xyz) >> int(kNode8ExponentBits)) * kNode8OriginStep;
  const vec3 scale = uintBitsToFloat(((node.a.xyz & ((1u << kNode8ExponentBits) - 1u)) + kNode8ExponentBias) << 23u);
  const GridRay g = make_grid_ray(origin, scale, walk.rf.ray.o, walk.inv_d);
  const uvec4 x = g.forward.x ? node.b : node.b.zwxy;  // near planes first
  const uvec4 y = g.forward.y ? node.c : node.c.zwxy;
  const uvec4 z = g.forward.z ? planes_z : planes_z.zwxy;
  ivec4 near_low, far_low, near_high, far_high;
  test_slabs(g, uvec3(x.x, y.x, z.x), uvec3(x.z, y.z, z.z), walk.nearest.t, near_low, far_low);
  test_slabs(g, uvec3(x.y, y.y, z.y), uvec3(x.w, y.w, z.w), walk.nearest.t, near_high, far_high);
  const uint last = (node.a.w >> kNode8CountShift) & 7u;
  const uvec4 low = (uvec4(near_low) & 0xfffffff8u) | uvec4(0u, 1u, 2u, 3u);
  const uvec4 high = (uvec4(near_high) & 0xfffffff8u) | uvec4(4u, 5u, 6u, 7u);
  // Children from 2 on may be missing; their boxes are empty, but a flat node could still let a ray through.
  return ChildKeys(uvec4(near_low.x <= far_low.x ? low.x : kMissKey, near_low.y <= far_low.y ? low.y : kMissKey,
                         near_low.z <= far_low.z && last >= 2u ? low.z : kMissKey, near_low.w <= far_low.w && last >= 3u ? low.w : kMissKey),
                   uvec4(near_high.x <= far_high.x && last >= 4u ? high.x : kMissKey, near_high.y <= far_high.y && last >= 5u ? high.y : kMissKey,
                         near_high.z <= far_high.z && last >= 6u ? high.z : kMissKey, near_high.w <= far_high.w && last >= 7u ? high.w : kMissKey));
}

// Ascending: the shortest network for eight, 19 comparators in six layers [Knuth1998].
ChildKeys sort_keys(ChildKeys k) {
  uvec4 l = k.low, h = k.high;
#define ORDER(p, q) { const uint smaller = min(p, q); q = max(p, q); p = smaller; }
  ORDER(l.x, l.z) ORDER(l.y, l.w) ORDER(h.x, h.z) ORDER(h.y, h.w)
  ORDER(l.x, h.x) ORDER(l.y, h.y) ORDER(l.z, h.z) ORDER(l.w, h.w)
  ORDER(l.x, l.y) ORDER(l.z, l.w) ORDER(h.x, h.y) ORDER(h.z, h.w)
  ORDER(l.z, h.x) ORDER(l.w, h.y)
  ORDER(l.y, h.x) ORDER(l.w, h.z)
  ORDER(l.y, l.z) ORDER(l.w, h.x) ORDER(h.y, h.z)
#undef ORDER
  return ChildKeys(l, h);
}

uint count_hits(uvec4 k) { return uint(k.x != kMissKey) + uint(k.y != kMissKey) + uint(k.z != kMissKey) + uint(k.w != kMissKey); }

NodeVisit visit_node(Walk walk, Record node) {
  // For a primitive this over-reads one texel; the value is unused.
  const uvec4 planes_z = load_record(walk.current + 3u);
  const ChildKeys k = sort_keys(child_keys(walk, node, planes_z));
  const uint hits = count_hits(k.low) + count_hits(k.high);
  const uvec3 l = k.low.yzw & 7u;
  const uvec4 h = k.high & 7u;
  const uint order = l.x | (l.y << 3u) | (l.z << 6u) | (h.x << 9u) | (h.y << 12u) | (h.z << 15u) | (h.w << 18u);
  return NodeVisit(hits, child_slot(node.a.w, k.low.x & 7u), StackEntry(node.a.w & 0xfffffffu, ((hits - 1u) << 21u) | order));
}

#endif
