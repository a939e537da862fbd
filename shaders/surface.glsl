// A hit point as materials and lights see it.
#ifndef SURFACE_GLSL
#define SURFACE_GLSL

#include "intersect.glsl"
#include "mutants.h"
#include "place.glsl"
#include "vertex_normals.glsl"

layout(constant_id = kConstantVertexNormals) const bool kVertexNormals = true;  // of any mesh

// What a ray hit: identity, distance and, on a triangle or a disk, the barycentric weights of its vertices. The primitive is included because whoever
// found the hit has already loaded it.
struct Hit {
  uint instance;   // kNone: nothing
  uint primitive;  // triangle within the mesh; 0 on other shapes
  float t;
  vec3 weights;
  Primitive geometry;
};

// The weights are computed again: carrying them along from the test would cost every step of a walk.
Hit make_hit(Ray ray, float t, bool found, Primitive prim) {
  Hit hit;
  hit.instance = found ? prim.instance : kNone;
  hit.primitive = prim.primitive;
  hit.t = t;
  hit.weights = triangle_weights(make_ray_frame(ray), prim.p0 - ray.o, prim.p1 - ray.o, prim.p2 - ray.o);
  hit.geometry = prim;
  return hit;
}

// The same on a primitive of a shared mesh: its weights are computed in the mesh's space, as during the walk, so that the hit is indistinguishable
// from others. Weights and vertices keep the order that they have in the mesh, even if the instance reverses the winding.
Hit make_shared_hit(Ray ray, float t, bool found, uint instance, Primitive prim) {
  Hit hit = make_hit(ray, t, found, prim);
  const uint place_index = found ? fetch_instance_place(instance) : kNone;
  if (place_index == kNone) return hit;
  const Place place = fetch_place(place_index);
  const vec3 o = to_place(place.object_x, place.object_y, place.object_z, ray.o - place.origin);
  const vec3 d = to_place(place.object_x, place.object_y, place.object_z, ray.d);
  hit.instance = instance;
  hit.weights = triangle_weights(make_scaled_ray(Ray(o, 0.0, d, t)).rf, prim.p0 - o, prim.p1 - o, prim.p2 - o);
  hit.geometry = place_triangle(place, prim, instance);
  return hit;
}

struct Surface {
  vec3 p;
  float error;         // see surface_error
  vec3 ng;
  uint instance;
  ShadingFrame frame;  // frame.n is the shading normal
  uint primitive;      // within its mesh
  vec3 base;           // the shading normal before maps turned it
  bool shadowed;       // by the turned normal; used only with kLooseMaps
};

// Bound on the distance between a computed point of the primitive and the true surface, with room for the next ray's own intersection
// error: 8 units in the last place of the largest coordinate involved.
float surface_error(Primitive prim) {
  float scale = is_sphere(prim)
                    ? max_component(abs(prim.p0)) + prim.p1.x
                    : max(max_component(abs(prim.p0)), max(max_component(abs(prim.p1)), max_component(abs(prim.p2))));
  if (is_disk(prim)) scale += max_component(abs(prim.p1 - prim.p0)) + max_component(abs(prim.p2 - prim.p0));
  if (is_cylinder(prim)) scale = max(max_component(abs(prim.p0)), max_component(abs(prim.p1))) + prim.p2.x;
  return scale * (8.0 / 8388608.0);
}

// Scaled before it is normalised: the square of a tiny triangle's area would vanish.
vec3 triangle_normal(Primitive tri) {
  const vec3 n = cross(tri.p1 - tri.p0, tri.p2 - tri.p0);
  return normalize(n / max_component(abs(n)));
}

// Interpolated vertex normal; ng where the mesh has none or they cancel.
vec3 shading_normal(Instance instance, uint primitive, vec3 weights, vec3 ng) {
  if (!kVertexNormals || instance.first_triangle == kNone) return ng;
  VertexNormals corners = unfold_normals(fetch_vertex_normals(instance.first_triangle + primitive));
  if (kInstanced && instance.place != kNone) {
    const Place place = fetch_place(instance.place);
    corners = VertexNormals(place_normal(place, corners.n0), place_normal(place, corners.n1), place_normal(place, corners.n2));
  }
  const vec3 n = weights.x * corners.n0 + weights.y * corners.n1 + weights.z * corners.n2;
  const float len = length(n);
  return len > 0.0 ? n * (1.0 / len) : ng;
}

// Barycentric weights kept slightly inside the triangle, by a few units in the last place of its size. A point rounded onto an edge may be beyond the
// neighbour across the edge, and a ray from there would leave a closed box.
vec3 inner_weights(vec3 weights) {
  const vec3 b = max(weights, vec3(1.0 / 4194304.0));
  return b * (1.0 / (b.x + b.y + b.z));
}

// The weights of a hit as needed by textures: on a cylinder those of the ends of its axis.
vec3 attribute_weights(Hit hit, Surface s) {
  if (!is_cylinder(hit.geometry)) return hit.weights;
  const vec3 axis = hit.geometry.p1 - hit.geometry.p0;
  const float along = clamp(dot(s.p - hit.geometry.p0, axis) / dot(axis, axis), 0.0, 1.0);
  return vec3(1.0 - along, along, 0.0);
}

Surface make_surface(Ray ray, Hit hit, Instance instance) {
  const Primitive prim = hit.geometry;
  Surface s;
  s.instance = hit.instance;
  s.primitive = hit.primitive;
  s.error = surface_error(prim);
  vec3 ns;
  if (is_sphere(prim)) {
    s.ng = normalize(ray.o + hit.t * ray.d - prim.p0);
    s.p = prim.p0 + prim.p1.x * s.ng;  // back onto the sphere: the error no longer grows with the distance
    if (is_inward(prim)) s.ng = -s.ng;
    ns = s.ng;
  } else if (is_cylinder(prim)) {
    s.p = onto_cylinder(ray.o + hit.t * ray.d, prim.p0, prim.p1, prim.p2.xy, s.ng);
    ns = s.ng;
  } else if (is_disk(prim)) {
    s.ng = triangle_normal(prim);
    s.p = prim.p0 + hit.weights.y * (prim.p1 - prim.p0) + hit.weights.z * (prim.p2 - prim.p0);
    ns = s.ng;
  } else {
    s.ng = triangle_normal(prim);
    if (kInstanced && instance.place != kNone) {
      const Place place = fetch_place(instance.place);
      s.ng *= place.side;
      s.error += place.error;
    }
    const vec3 b = inner_weights(hit.weights);
    s.p = b.x * prim.p0 + b.y * prim.p1 + b.z * prim.p2;
    ns = shading_normal(instance, hit.primitive, hit.weights, s.ng);
    MUTATE(kMutantSideByWinding, if (dot(ns, s.ng) < 0.0) ns = -ns)
  }
  s.frame = make_frame(ns);
  s.base = ns;
  s.shadowed = true;
  return s;
}

// The surface passed by a ray that continues behind a hit at t.
Passed pass_behind(Surface s, float t, vec3 d) {
  const float cosine = max(abs(dot(s.ng, d)), 0.01);
  return Passed(s.instance, t + 2.0 * s.error / cosine);
}

#endif
