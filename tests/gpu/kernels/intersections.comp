#version 460
#extension GL_GOOGLE_include_directive : require
#include "intersect.glsl"
#include "test_io.glsl"

TEST_BUFFERS(IntersectCase, IntersectAnswer)

void main() {
  if (!lane_has_work()) return;
  const IntersectCase c = inputs[lane()];
  const Ray ray = Ray(c.o, c.t_min, c.d, c.t_max);
  float t = 0.0;
  vec3 weights = vec3(0.0);
  bool found;
  if (c.kind == kPrimitiveSphere) {
    found = intersect_sphere(ray, c.p0, c.p1.x, c.t_max, t);
  } else if (c.kind == kPrimitiveCylinder) {
    found = intersect_cylinder(ray, c.p0, c.p1, c.p2.x, c.t_max, t);
  } else if (c.kind == kPrimitiveDisk) {
    found = intersect_disk(make_ray_frame(ray), c.p0, c.p1, c.p2, c.t_max, t);
  } else {
    const RayFrame rf = make_ray_frame(ray);
    found = intersect_triangle(rf, c.p0, c.p1, c.p2, c.t_max, t);
    weights = triangle_weights(rf, c.p0 - c.o, c.p1 - c.o, c.p2 - c.o);
  }
  outputs[lane()] = IntersectAnswer(found ? 1u : 0u, t, weights.y, weights.z);
}
