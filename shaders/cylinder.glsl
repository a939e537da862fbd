// The curved side of a cylinder, open at both ends: its axis runs from p0 to p1, its radius is p2.x, and p2.y is 1 where its normal points away from
// the axis and −1 where it points toward it.
#ifndef CYLINDER_GLSL
#define CYLINDER_GLSL

#include "ray.glsl"

// Nearest intersection beyond t_min. The quadratic is that of the ray seen along the axis, solved about the point nearest to it, as for a sphere
// [Haines2019]; a ray along the axis meets nothing.
bool intersect_cylinder(Ray ray, vec3 p0, vec3 p1, float radius, float t_max, out float t) {
  const vec3 axis = p1 - p0;
  const float height = length(axis);
  const vec3 w = axis * (1.0 / height);
  const vec3 f = ray.o - p0;
  const float f_along = dot(f, w);
  const float d_along = dot(ray.d, w);
  const vec3 f_across = f - f_along * w;
  const vec3 d_across = ray.d - d_along * w;
  const float a = dot(d_across, d_across);
  const float b = -dot(f_across, d_across);
  const vec3 l = f_across + (b / a) * d_across;
  const float discriminant = radius * radius - dot(l, l);
  const float root = sqrt(max(0.0, a * discriminant));
  const float q = b + (b >= 0.0 ? root : -root);
  const float c = (length(f_across) - radius) * (length(f_across) + radius);
  const float t0 = q == 0.0 ? 0.0 : c / q;
  const float t1 = q / a;
  const float near = min(t0, t1);
  const float far = max(t0, t1);
  const float near_along = f_along + near * d_along;
  t = near > ray.t_min && near_along >= 0.0 && near_along <= height ? near : far;
  MUTATE(kMutantCylinderOutsideOnly, t = near);
  const float along = f_along + t * d_along;
  return a > 0.0 && discriminant >= 0.0 && t > ray.t_min && t < t_max && along >= 0.0 && along <= height;
}

// The point of the side that is nearest to p, and its normal.
vec3 onto_cylinder(vec3 p, vec3 p0, vec3 p1, vec2 radius_side, out vec3 n) {
  const vec3 axis = p1 - p0;
  const float height = length(axis);
  const vec3 w = axis * (1.0 / height);
  const float along = clamp(dot(p - p0, w), 0.0, height);
  const vec3 foot = p0 + along * w;
  const vec3 across = p - foot;
  const vec3 outward = normalize(across - dot(across, w) * w);
  n = radius_side.y * outward;
  return foot + radius_side.x * outward;
}

#endif
