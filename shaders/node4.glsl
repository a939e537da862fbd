// Nodes with up to four children: their boxes against a ray, and the walk's memory of them. See Record in gpu_types.h.
#ifndef NODE4_GLSL
#define NODE4_GLSL

#include "slabs.glsl"

// A node's children still to be visited: its child base / 2 in the upper 24 bits, their number in bits 6–7 and their indices, nearest first, two
// bits each from bit 0.
#define StackEntry uint

uint children_left(StackEntry e) { return (e >> 6u) & 3u; }
uint next_child(StackEntry e) { return ((e >> 7u) & 0x1fffffeu) + (e & 3u); }
StackEntry without_next(StackEntry e) { return (e & 0xffffff00u) | ((children_left(e) - 1u) << 6u) | ((e & 0x3fu) >> 2u); }

// The children of a node that a ray hits: their number, the slot of the nearest and, if there are more, the entry of the others.
struct NodeVisit {
  uint hits;
  uint nearest;
  StackEntry others;
};

uvec4 child_keys(Walk walk, Record node) {
  const vec3 scale = uintBitsToFloat(uvec3(node.a.w << 23u, (node.a.w << 15u) & 0x7f800000u, (node.a.w << 7u) & 0x7f800000u) & 0x7f800000u);
  const GridRay g = make_grid_ray(uintBitsToFloat(node.a.xyz), scale, walk.rf.ray.o, walk.inv_d);
  ivec4 near, far;
  test_slabs(g, mix(node.c.xyz, node.b.xyz, g.forward), mix(node.b.xyz, node.c.xyz, g.forward), walk.nearest.t, near, far);
  const uint count = (node.a.w >> kNode4CountShift) & 7u;
  const uvec4 keys = (uvec4(near) & 0xfffffffcu) | uvec4(0u, 1u, 2u, 3u);
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

NodeVisit visit_node(Walk walk, Record node) {
  const uvec4 keys = sort_keys(child_keys(walk, node));
  const uint hits = uint(keys.x != kMissKey) + uint(keys.y != kMissKey) + uint(keys.z != kMissKey) + uint(keys.w != kMissKey);
  const uint others = (node.b.w << 7u) | ((hits - 1u) << 6u) | (keys.y & 3u) | ((keys.z & 3u) << 2u) | ((keys.w & 3u) << 4u);
  return NodeVisit(hits, node.b.w + (keys.x & 3u), others);
}

#endif
