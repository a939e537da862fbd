// The only file with descriptor bindings of the scene: typed fetch functions for everything the host uploaded.
#ifndef SCENE_GLSL
#define SCENE_GLSL

#include "gpu_types.h"

layout(set = 0, binding = kBindingFrame, std140) uniform FrameBlock { Frame frame; };
// Tables come through texel buffers: one 128-bit load a texel where storage buffers are loaded word by word (lavapipe), the texture cache on GPUs,
// and up to 2^27 texels where a storage buffer may end at 128 MiB.
layout(set = 0, binding = kBindingRecords) uniform usamplerBuffer record_texels;
layout(set = 0, binding = kBindingShapes) uniform usamplerBuffer shape_texels;
layout(set = 0, binding = kBindingTriangles) uniform usamplerBuffer triangle_texels;
layout(set = 0, binding = kBindingNormals) uniform usamplerBuffer normal_texels;
layout(set = 0, binding = kBindingLightShapes) uniform usamplerBuffer light_shape_texels;
layout(set = 0, binding = kBindingLightPrimitives) uniform usamplerBuffer light_primitive_texels;
layout(set = 0, binding = kBindingFilter, std430) readonly buffer FilterBuffer { float filter_knots[]; };

Record fetch_record(uint i) {
  const int texel = int(3u * i);
  return Record(texelFetch(record_texels, texel), texelFetch(record_texels, texel + 1), texelFetch(record_texels, texel + 2));
}
Primitive to_primitive(Record r) {
  return Primitive(uintBitsToFloat(r.a.xyz), r.a.w, uintBitsToFloat(r.b.xyz), r.b.w, uintBitsToFloat(r.c.xyz), r.c.w);
}
Primitive fetch_primitive(uint slot) { return to_primitive(fetch_record(slot)); }
Shape fetch_shape(uint i) {
  const uvec4 a = texelFetch(shape_texels, int(3u * i));
  const uvec4 b = texelFetch(shape_texels, int(3u * i + 1u));
  const uvec4 c = texelFetch(shape_texels, int(3u * i + 2u));
  return Shape(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), uintBitsToFloat(b.w), uintBitsToFloat(c.x), uintBitsToFloat(c.y),
               uintBitsToFloat(c.z), c.w);
}
LightShape fetch_light_shape(uint i) {
  const uvec4 a = texelFetch(light_shape_texels, int(i));
  return LightShape(a.x, a.y, a.z, a.w);
}
LightPrimitive fetch_light_primitive(uint i) {
  const uvec4 a = texelFetch(light_primitive_texels, int(i));
  return LightPrimitive(a.x, a.y, uintBitsToFloat(a.z), a.w);
}
// Vertex indices of a triangle in xyz; only for shapes with vertex normals.
uvec3 fetch_triangle(uint i) { return texelFetch(triangle_texels, int(i)).xyz; }
vec3 fetch_normal(uint i) { return uintBitsToFloat(texelFetch(normal_texels, int(i)).xyz); }
// Offset in pixels at u = i / kFilterSteps.
float fetch_filter_knot(uint i) { return filter_knots[i]; }

#endif
