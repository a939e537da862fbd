// Ray against one primitive. The same functions serve closest and any hit.
#ifndef INTERSECT_GLSL
#define INTERSECT_GLSL

#include "features.glsl"
#include "cylinder.glsl"
#include "frame.glsl"
#include "material_flags.glsl"
#include "ray.glsl"
#include "scene.glsl"

layout(constant_id = kConstantHasSpheres) const bool kHasSpheres = true;
FEATURE(bool, kInwardSpheres, kConstantInwardSpheres, false)  // some have normals toward their centre
FEATURE(bool, kHasDisks, kConstantHasDisks, false)
FEATURE(bool, kHasCylinders, kConstantHasCylinders, false)
// The primitives that are tested before the tree, see kFewPrimitives.
layout(constant_id = kConstantFewCount) const uint kFewCount = 0u;
layout(constant_id = kConstantFewSpheres) const uint kFewSpheres = 0u;  // bit i: the i-th of them is a sphere
FEATURE(uint, kFewDisks, kConstantFewDisks, 0u)
FEATURE(uint, kFewCylinders, kConstantFewCylinders, 0u)

// Their words: kFew<i>_<k> is float k of p0, p1, p2 of primitive i, kFew<i>_9 its instance.
#define FOR_EACH_FEW(X) \
  X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11) X(12) X(13) X(14) X(15) X(16) X(17) X(18) X(19) X(20) X(21) X(22) X(23)
#define FEW_VALUE(i, k) layout(constant_id = kConstantFew + kFewWords * i + k) const float kFew##i##_##k = 0.0;
#define FEW_VALUES_OF(i)                                                                                    \
  FEW_VALUE(i, 0) FEW_VALUE(i, 1) FEW_VALUE(i, 2) FEW_VALUE(i, 3) FEW_VALUE(i, 4) FEW_VALUE(i, 5) FEW_VALUE(i, 6) \
  FEW_VALUE(i, 7) FEW_VALUE(i, 8) layout(constant_id = kConstantFew + kFewWords * i + kFewFloats) const uint kFew##i##_9 = 0u;
FOR_EACH_FEW(FEW_VALUES_OF)
#define FEW_VALUES(i) \
  vec3(kFew##i##_0, kFew##i##_1, kFew##i##_2), vec3(kFew##i##_3, kFew##i##_4, kFew##i##_5), vec3(kFew##i##_6, kFew##i##_7, kFew##i##_8)

#define FEW_CYLINDER(i) \
  vec3(kFew##i##_0, kFew##i##_1, kFew##i##_2), vec3(kFew##i##_3, kFew##i##_4, kFew##i##_5), kFew##i##_6

// A surface that a ray has passed: the ray continues from t_min, the distance of that hit. At t_min itself, instances later in the order of the scene
// still count; its own surface counts only beyond t_own, or a ray through an edge would hit both of its triangles.
struct Passed {
  uint instance;  // kNone: nothing
  float t_own;
};
const Passed kNothingPassed = Passed(kNone, 0.0);

// The nearest primitive so far, while primitives are being tested.
struct Nearest {
  float t;
  uint slot;   // of its record; kNone for none
  uint order;  // its Primitive::kind, which numbers the primitives of the scene; 0 for none, so that nothing at t itself precedes it
  uint instance;  // its instance; used where meshes are shared, as their primitives are numbered within them
};

// Whether no light passes a primitive of this Primitive::kind.
bool is_opaque(uint kind) { return !kPassable || (kind & kPrimitivePassable) == 0u; }

bool is_sphere(Primitive prim) { return kHasSpheres && (prim.kind & kPrimitiveKindMask) == kPrimitiveSphere; }
bool is_inward(Primitive sphere) { return kInwardSpheres && sphere.p1.y != 0.0; }

#define is_disk(prim) (kHasDisks && ((prim).kind & kPrimitiveKindMask) == kPrimitiveDisk)
#define is_cylinder(prim) (kHasCylinders && ((prim).kind & kPrimitiveKindMask) == kPrimitiveCylinder)

// A ray with the plane perpendicular to it: every primitive is projected onto (s, t) and tested in 2D.
struct RayFrame {
  Ray ray;
  vec3 s, t;
};

RayFrame make_ray_frame(Ray ray) {
  const ShadingFrame f = make_frame(ray.d);
  return RayFrame(ray, f.s, f.t);
}

// A ray whose direction is not of unit length. Distances are dot products with d / d², so that is what the ray of its frame carries. The frame was
// computed from `unit` and `size`, direction and length of d: boxes must use the same direction as triangles, or rounding separates them.
struct ScaledRay {
  RayFrame rf;
  vec3 unit;
  float size;
};
vec3 unit_of(vec3 d, float size) {
  const vec3 unit = d / size;
  return unit * (1.5 - 0.5 * dot(unit, unit));  // once more, where length() is not exact
}
// `ray` has the direction of unit length.
RayFrame make_scaled_frame(Ray ray, float size) {
  const ShadingFrame f = make_frame(ray.d);
  MUTATE(kMutantInstanceRayNormalised, size = 1.0);
  ray.d /= size;
  return RayFrame(ray, f.s, f.t);
}
ScaledRay make_scaled_ray(Ray ray) {
  const float size = length(ray.d);
  ray.d = unit_of(ray.d, size);
  return ScaledRay(make_scaled_frame(ray, size), ray.d, size);
}

// Barycentric weights of the point where the ray hits a triangle's plane; a, b, c are its vertices relative to the ray's origin. None of them is
// negative if the ray hits the triangle. If it is seen edge-on, or has no area, they are infinite or NaN.
//
// Watertight: a vertex shared by two triangles projects to the same 2D point and the edge function of a shared edge is the exact negative
// seen from the other side, so no ray passes between them (the idea of [Woop2013], with a rotation in place of their shear). `precise`
// keeps a driver from fusing the products, which would break that symmetry.
vec3 triangle_weights(RayFrame rf, vec3 a, vec3 b, vec3 c) {
  precise const vec2 pa = vec2(rf.s.x * a.x + rf.s.y * a.y + rf.s.z * a.z, rf.t.x * a.x + rf.t.y * a.y + rf.t.z * a.z);
  precise const vec2 pb = vec2(rf.s.x * b.x + rf.s.y * b.y + rf.s.z * b.z, rf.t.x * b.x + rf.t.y * b.y + rf.t.z * b.z);
  precise const vec2 pc = vec2(rf.s.x * c.x + rf.s.y * c.y + rf.s.z * c.z, rf.t.x * c.x + rf.t.y * c.y + rf.t.z * c.z);
  precise const vec3 areas = vec3(pb.x * pc.y - pc.x * pb.y, pc.x * pa.y - pa.x * pc.y, pa.x * pb.y - pb.x * pa.y);
  return areas * (1.0 / (areas.x + areas.y + areas.z));
}

// Points on an edge count as hits; a triangle without weights is never hit, because infinities have both signs and comparisons with NaN fail.
bool intersect_triangle(RayFrame rf, vec3 p0, vec3 p1, vec3 p2, float t_max, out float t) {
  const vec3 a = p0 - rf.ray.o;
  const vec3 b = p1 - rf.ray.o;
  const vec3 c = p2 - rf.ray.o;
  const vec3 weights = triangle_weights(rf, a, b, c);
  t = dot(weights, vec3(dot(rf.ray.d, a), dot(rf.ray.d, b), dot(rf.ray.d, c)));
  return weights.x >= 0.0 && weights.y >= 0.0 && weights.z >= 0.0 && t > rf.ray.t_min && t < t_max;
}

// A disk under an affine map: the weights of the ends of its half axes are the coordinates of the point in the unit disk.
bool intersect_disk(RayFrame rf, vec3 p0, vec3 p1, vec3 p2, float t_max, out float t) {
  const vec3 a = p0 - rf.ray.o;
  const vec3 b = p1 - rf.ray.o;
  const vec3 c = p2 - rf.ray.o;
  const vec3 weights = triangle_weights(rf, a, b, c);
  t = dot(weights, vec3(dot(rf.ray.d, a), dot(rf.ray.d, b), dot(rf.ray.d, c)));
  float r2 = dot(weights.yz, weights.yz);
  MUTATE(kMutantDiskSquare, r2 = max(weights.y * weights.y, weights.z * weights.z));
  return r2 <= 1.0 && t > rf.ray.t_min && t < t_max;
}

// Nearest intersection beyond t_min; the quadratic is solved about the point of the ray nearest to the centre, which preserves precision for small or
// distant spheres [Haines2019].
bool intersect_sphere(Ray ray, vec3 center, float radius, float t_max, out float t) {
  const vec3 f = ray.o - center;
  const float b = -dot(f, ray.d);
  const vec3 l = f + b * ray.d;
  const float discriminant = radius * radius - dot(l, l);
  const float root = sqrt(max(0.0, discriminant));
  const float q = b + (b >= 0.0 ? root : -root);
  const float c = (length(f) - radius) * (length(f) + radius);
  const float t0 = q == 0.0 ? 0.0 : c / q;
  const float near = min(t0, q);
  const float far = max(t0, q);
  t = near > ray.t_min ? near : far;
  return discriminant >= 0.0 && t > ray.t_min && t < t_max;
}

// The distance beyond which a ray that has passed a surface meets the primitives of an instance.
float start_for(uint instance, float t_min, Passed passed) {
  if (instance == passed.instance) return passed.t_own;
  // For instances later in the order, the float before t_min, so that t_min itself is beyond it.
  return instance > passed.instance ? uintBitsToFloat(floatBitsToUint(t_min) - 1u) : t_min;
}

// Tests a primitive record and accepts it if it is nearer, or equally near and earlier in the scene: which of two coincident surfaces is visible must
// not depend on the order of the walk.
bool intersect_primitive(RayFrame rf, Record record, uint slot, uint instance, Passed passed, inout Nearest nearest) {
  const Primitive prim = to_primitive(record);
  if (kPassable) rf.ray.t_min = start_for(instance, rf.ray.t_min, passed);
  bool earlier = prim.kind < nearest.order;
  if (kInstanced) earlier = instance < nearest.instance || (instance == nearest.instance && earlier);
  MUTATE(kMutantTiesReversed, earlier = !earlier)
  // For an instance earlier in the order, the next float after t, so that t itself is excluded.
  const float reach = uintBitsToFloat(floatBitsToUint(nearest.t) + uint(earlier));
  float t;
  bool found = intersect_triangle(rf, prim.p0, prim.p1, prim.p2, reach, t);
  if (is_sphere(prim)) found = intersect_sphere(rf.ray, prim.p0, prim.p1.x, reach, t);
  if (is_disk(prim)) found = intersect_disk(rf, prim.p0, prim.p1, prim.p2, reach, t);
  if (is_cylinder(prim)) found = intersect_cylinder(rf.ray, prim.p0, prim.p1, prim.p2.x, reach, t);
  nearest = Nearest(found ? t : nearest.t, found ? slot : nearest.slot, found ? prim.kind : nearest.order, found ? instance : nearest.instance);
  return found;
}

// The primitives outside the tree: everything about them is a constant, so nothing is loaded, vertices shared by triangles are projected once, and no
// lane waits for another. They are tested in the order of the scene, so the first of equally near ones is kept.
#define TEST_FEW(i)                                                                                                       \
  if (i < kFewCount) {                                                                                                    \
    bool found;                                                                                                           \
    if (kPassable) rf.ray.t_min = start_for(kFew##i##_9, t_min, passed);                                                  \
    if ((kFewSpheres >> i & 1u) != 0u) {                                                                                  \
      found = intersect_sphere(rf.ray, vec3(kFew##i##_0, kFew##i##_1, kFew##i##_2), kFew##i##_3, nearest.t, t);           \
    } else if ((kFewDisks >> i & 1u) != 0u) {                                                                             \
      found = intersect_disk(rf, FEW_VALUES(i), nearest.t, t);                                                            \
    } else if ((kFewCylinders >> i & 1u) != 0u) {                                                                         \
      found = intersect_cylinder(rf.ray, FEW_CYLINDER(i), nearest.t, t);                                                  \
    } else {                                                                                                              \
      found = intersect_triangle(rf, FEW_VALUES(i), nearest.t, t);                                                        \
    }                                                                                                                     \
    nearest.t = found ? t : nearest.t;                                                                                    \
    nearest.slot = found ? i * kPrimitiveSlots : nearest.slot;                                                            \
  }
Nearest intersect_few_primitives(RayFrame rf, Passed passed) {
  const float t_min = rf.ray.t_min;
  Nearest nearest = Nearest(rf.ray.t_max, kNone, 0u, 0u);
  float t;
  FOR_EACH_FEW(TEST_FEW)
  return nearest;
}

#endif
