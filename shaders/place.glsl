// Placement of shared meshes by instances: points, normals and areas to the world, rays the other way.
#ifndef PLACE_GLSL
#define PLACE_GLSL

#include "ray.glsl"
#include "scene.glsl"

vec3 place_point(Place place, vec3 p) { return place.x * p.x + place.y * p.y + place.z * p.z + place.origin; }

// A unit vertex normal in the world, on the side of the surface given by the instance. The cofactors of the matrix map
// cross products of edges to those of transformed edges; they are formed in units of the longest axis, because the
// square of a tiny instance would vanish.
vec3 place_normal(Place place, vec3 n) {
  const float unit = 1.0 / max_component(max(abs(place.x), max(abs(place.y), abs(place.z))));
  const vec3 x = place.x * unit, y = place.y * unit, z = place.z * unit;
  vec3 placed = cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z;
  MUTATE(kMutantInstanceNormalMatrix, placed = (x * n.x + y * n.y + z * n.z) * sign(dot(x, cross(y, z))));
  float side = place.side;
  MUTATE(kMutantInstanceSideLost, side = 1.0);
  return normalize(placed / max_component(abs(placed))) * side;
}

Primitive place_triangle(Place place, Primitive object, uint instance) {
  return Primitive(place_point(place, object.p0), instance, place_point(place, object.p1), object.primitive, place_point(place, object.p2), object.kind);
}

// Ratio of an area with normal ng in the world to that in the mesh's space: |det M| / |Mᵀ ng|.
float place_area_factor(Place place, vec3 ng) {
  return place.root_determinant / length(vec3(dot(place.x, ng), dot(place.y, ng), dot(place.z, ng))) * place.root_determinant;
}

// The point and the direction in the mesh's space, seen from the place's origin. The direction is not normalised, so that distances stay those
// of the world; r are the rows of object_from_world.
vec3 to_place(vec3 r0, vec3 r1, vec3 r2, vec3 v) { return vec3(dot(r0, v), dot(r1, v), dot(r2, v)); }

#endif
