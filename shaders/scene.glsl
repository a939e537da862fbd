// The only file with descriptor bindings of the scene: typed fetch functions for everything the host uploaded.
#ifndef SCENE_GLSL
#define SCENE_GLSL

#include "gpu_types.h"

layout(set = 0, binding = kBindingFrame, std140) uniform FrameBlock { Frame frame; };
// Records come through a texel buffer: one 128-bit load a texel where storage buffers are loaded word by word (lavapipe), the texture
// cache on GPUs, and up to 2^27 texels where a storage buffer may end at 128 MiB.
layout(set = 0, binding = kBindingRecords) uniform usamplerBuffer record_texels;
layout(set = 0, binding = kBindingFewPrimitives, std140) uniform FewPrimitivesBlock { Record few_primitives[kFewPrimitives]; };
layout(set = 0, binding = kBindingShapes, std430) readonly buffer ShapeBuffer { Shape shapes[]; };
layout(set = 0, binding = kBindingTriangles, std430) readonly buffer TriangleBuffer { uvec4 triangles[]; };
layout(set = 0, binding = kBindingNormals, std430) readonly buffer NormalBuffer { vec4 normals[]; };
layout(set = 0, binding = kBindingLightShapes, std430) readonly buffer LightShapeBuffer { LightShape light_shapes[]; };
layout(set = 0, binding = kBindingLightPrimitives, std430) readonly buffer LightPrimitiveBuffer { LightPrimitive light_primitives[]; };
layout(set = 0, binding = kBindingFilter, std430) readonly buffer FilterBuffer { float filter_knots[]; };

Record fetch_record(uint i) {
  const int texel = int(3u * i);
  return Record(texelFetch(record_texels, texel), texelFetch(record_texels, texel + 1), texelFetch(record_texels, texel + 2));
}
Primitive to_primitive(Record r) {
  return Primitive(uintBitsToFloat(r.a.xyz), r.a.w, uintBitsToFloat(r.b.xyz), r.b.w, uintBitsToFloat(r.c.xyz), r.c.w);
}
// For a constant index and scenes of few primitives: a load that all lanes share.
Primitive fetch_few_primitive(uint slot) { return to_primitive(few_primitives[slot]); }
Primitive fetch_primitive(uint slot) { return to_primitive(fetch_record(slot)); }
Shape fetch_shape(uint i) { return shapes[i]; }
LightShape fetch_light_shape(uint i) { return light_shapes[i]; }
LightPrimitive fetch_light_primitive(uint i) { return light_primitives[i]; }
// Vertex indices of a triangle in xyz; only for shapes with vertex normals.
uvec3 fetch_triangle(uint i) { return triangles[i].xyz; }
vec3 fetch_normal(uint i) { return normals[i].xyz; }
// Offset in pixels at u = i / kFilterSteps.
float fetch_filter_knot(uint i) { return filter_knots[i]; }

#endif
