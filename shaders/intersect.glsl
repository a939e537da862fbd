// Ray against one primitive. The same functions serve closest and any hit.
#ifndef INTERSECT_GLSL
#define INTERSECT_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "frame.glsl"
#include "ray.glsl"
#include "scene.glsl"

layout(constant_id = 9) const bool kHasSpheres = true;
// Not 0 for scenes of at most kFewPrimitives primitives, which have no tree.
layout(constant_id = 10) const uint kFewTriangles = 0u;
layout(constant_id = 11) const uint kFewSpheres = 0u;

struct Hit {
  float t;
  uint slot;   // record of the primitive; kNone for no hit
  float b1;    // barycentric weights of p1 and p2; unused for a sphere
  float b2;
};

// A ray with the plane it is seen along: every primitive is projected onto (s, t), perpendicular to the ray, and tested in 2D.
struct RayFrame {
  Ray ray;
  vec3 s, t;
};

RayFrame make_ray_frame(Ray ray) {
  const ShadingFrame f = make_frame(ray.d);
  return RayFrame(ray, f.s, f.t);
}

// Watertight: a vertex shared by two triangles projects to the same 2D point and the edge function of a shared edge is the exact negative
// seen from the other side, so no ray passes between them (the idea of [Woop2013], with a rotation in place of their shear). `precise`
// keeps a driver from fusing the products, which would break that symmetry. Points on an edge count as hits; a triangle seen
// edge-on or of zero area has determinant 0 and is never hit.
bool intersect_triangle(RayFrame rf, Primitive tri, float t_max, out float t, out float b1, out float b2) {
  const vec3 a = tri.p0 - rf.ray.o;
  const vec3 b = tri.p1 - rf.ray.o;
  const vec3 c = tri.p2 - rf.ray.o;
  precise const vec2 pa = vec2(rf.s.x * a.x + rf.s.y * a.y + rf.s.z * a.z, rf.t.x * a.x + rf.t.y * a.y + rf.t.z * a.z);
  precise const vec2 pb = vec2(rf.s.x * b.x + rf.s.y * b.y + rf.s.z * b.z, rf.t.x * b.x + rf.t.y * b.y + rf.t.z * b.z);
  precise const vec2 pc = vec2(rf.s.x * c.x + rf.s.y * c.y + rf.s.z * c.z, rf.t.x * c.x + rf.t.y * c.y + rf.t.z * c.z);
  precise const float u = pb.x * pc.y - pc.x * pb.y;
  precise const float v = pc.x * pa.y - pa.x * pc.y;
  precise const float w = pa.x * pb.y - pb.x * pa.y;
  const float lowest = min(u, min(v, w));
  const float highest = max(u, max(v, w));
  const float det = u + v + w;
  const float inv_det = 1.0 / det;
  t = (u * dot(rf.ray.d, a) + v * dot(rf.ray.d, b) + w * dot(rf.ray.d, c)) * inv_det;
  b1 = v * inv_det;
  b2 = w * inv_det;
  return (lowest >= 0.0 || highest <= 0.0) && det != 0.0 && t > rf.ray.t_min && t < t_max;
}

// Nearest intersection beyond t_min; the quadratic is solved about the point of the ray nearest to the centre, which keeps its precision
// for small or distant spheres [Haines2019].
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

void shorten(inout Hit hit, bool found, float t, uint slot, float b1, float b2) {
  hit.t = found ? t : hit.t;
  hit.slot = found ? slot : hit.slot;
  hit.b1 = found ? b1 : hit.b1;
  hit.b2 = found ? b2 : hit.b2;
}

// Tests a primitive record and shortens `hit` when it is nearer.
bool intersect_primitive(RayFrame rf, Record record, uint slot, inout Hit hit) {
  const Primitive prim = to_primitive(record);
  float t, b1, b2;
  bool found = intersect_triangle(rf, prim, hit.t, t, b1, b2);
  if (kHasSpheres && prim.kind == kPrimitiveSphere) found = intersect_sphere(rf.ray, prim.p0, prim.p1.x, hit.t, t);
  shorten(hit, found, t, slot, b1, b2);
  return found;
}

// All primitives of a scene without a tree. The loops are unrolled: every index is a constant, so all lanes share each load and no lane
// waits for another.
Hit intersect_few_primitives(RayFrame rf) {
  Hit hit = Hit(rf.ray.t_max, kNone, 0.0, 0.0);
  [[unroll]] for (uint i = 0u; i < kFewTriangles; ++i) {
    float t, b1, b2;
    const bool found = intersect_triangle(rf, fetch_few_primitive(i), hit.t, t, b1, b2);
    shorten(hit, found, t, i, b1, b2);
  }
  [[unroll]] for (uint i = kFewTriangles; i < kFewTriangles + kFewSpheres; ++i) {
    const Primitive sphere = fetch_few_primitive(i);
    float t;
    const bool found = intersect_sphere(rf.ray, sphere.p0, sphere.p1.x, hit.t, t);
    shorten(hit, found, t, i, 0.0, 0.0);
  }
  return hit;
}

#endif
