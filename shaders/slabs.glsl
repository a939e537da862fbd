// The slab test of quantised boxes, four at a time.
#ifndef SLABS_GLSL
#define SLABS_GLSL

// A ray in the grid of a node's boxes: plane q of an axis is at distance q · a + b, up to rounding.
struct GridRay {
  vec3 a;
  vec3 b_near, b_far;
  bvec3 forward;  // whether lower planes are met before upper ones
};

GridRay make_grid_ray(vec3 origin, vec3 scale, vec3 ray_o, vec3 inv_d) {
  const vec3 b = (origin - ray_o) * inv_d;
  // Rounding must not lose a box: near planes are moved back and far planes forward by more than the error of b, and
  // the far distance is scaled by more than the error of the sum below [Ize2013].
  const vec3 margin = abs(b) * 3e-7;
  return GridRay(scale * inv_d, b - margin, b + margin, greaterThanEqual(inv_d, vec3(0.0)));
}

vec4 unpack_bytes(uint v) { return vec4(v & 0xffu, (v >> 8u) & 0xffu, (v >> 16u) & 0xffu, v >> 24u); }

// Bits of the distances at which the ray enters and leaves four boxes, one per byte of q_near and q_far: the ray meets
// those with near <= far. Nothing behind its start or beyond `t` counts. They are compared as integers, which order
// non-negative floats in the same way and take one instruction, where floats take three because of NaNs. Negative
// distances are in the wrong order among themselves but below all others, which is sufficient here.
void test_slabs(GridRay g, uvec3 q_near, uvec3 q_far, float t, out ivec4 near, out ivec4 far) {
  near = max(max(floatBitsToInt(unpack_bytes(q_near.x) * g.a.x + g.b_near.x), floatBitsToInt(unpack_bytes(q_near.y) * g.a.y + g.b_near.y)),
             max(floatBitsToInt(unpack_bytes(q_near.z) * g.a.z + g.b_near.z), ivec4(0)));
  const ivec4 far_exact = min(min(floatBitsToInt(unpack_bytes(q_far.x) * g.a.x + g.b_far.x), floatBitsToInt(unpack_bytes(q_far.y) * g.a.y + g.b_far.y)),
                              min(floatBitsToInt(unpack_bytes(q_far.z) * g.a.z + g.b_far.z), ivec4(floatBitsToInt(t))));
  far = floatBitsToInt(intBitsToFloat(far_exact) * (1.0 + 1e-6));
}

// The sort key of a box that is not hit. Others have the bits of the entry distance (non-negative floats order like integers), with the child's index
// in the lowest bits.
const uint kMissKey = 0xffffffffu;

#endif
