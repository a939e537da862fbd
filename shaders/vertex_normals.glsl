// The vertex normals of a triangle, from the texel that holds them: see kOctahedron.
#ifndef VERTEX_NORMALS_GLSL
#define VERTEX_NORMALS_GLSL

#include "gpu_types.h"

struct VertexNormals {
  vec3 n0, n1, n2;
};

// The unit vector whose x is in `word`, like the low bits of its y; `high` begins with the others. Its components are whole numbers, and exact,
// until they are divided by its length.
vec3 unfold_normal(uint word, uint high) {
  const int unused = 32 - int(kOctahedronBits);
  const int x = int(word << unused) >> unused;
  const int y = int((word >> kOctahedronBits | high << kOctahedronLowBits) << unused) >> unused;
  const int z = kOctahedron - abs(x) - abs(y);
  vec3 v = vec3(x, y, z);
  if (z < 0) {
    const int folded_x = kOctahedron - abs(y), folded_y = kOctahedron - abs(x);
    v = vec3(x < 0 ? -folded_x : folded_x, y < 0 ? -folded_y : folded_y, z);
  }
  return v / length(v);
}

VertexNormals unfold_normals(uvec4 words) {
  return VertexNormals(unfold_normal(words.x, words.w), unfold_normal(words.y, words.w >> kOctahedronHighBits),
                       unfold_normal(words.z, words.w >> 2u * kOctahedronHighBits));
}

#endif
