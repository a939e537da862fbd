// The only file with descriptor bindings of the scene: typed fetch functions for everything the host uploaded.
#ifndef SCENE_GLSL
#define SCENE_GLSL

#include "gpu_types.h"

layout(set = 0, binding = kBindingFrame, std140) uniform FrameBlock { Frame frame; };
layout(set = 0, binding = kBindingNodes, std430) readonly buffer NodeBuffer { BvhNode nodes[]; };
layout(set = 0, binding = kBindingPrimitives, std430) readonly buffer PrimitiveBuffer { Primitive primitives[]; };
layout(set = 0, binding = kBindingShapes, std430) readonly buffer ShapeBuffer { Shape shapes[]; };
layout(set = 0, binding = kBindingTriangles, std430) readonly buffer TriangleBuffer { uvec4 triangles[]; };
layout(set = 0, binding = kBindingNormals, std430) readonly buffer NormalBuffer { vec4 normals[]; };
layout(set = 0, binding = kBindingLightShapes, std430) readonly buffer LightShapeBuffer { LightShape light_shapes[]; };
layout(set = 0, binding = kBindingLightPrimitives, std430) readonly buffer LightPrimitiveBuffer { LightPrimitive light_primitives[]; };
layout(set = 0, binding = kBindingFilter, std430) readonly buffer FilterBuffer { float filter_knots[]; };

BvhNode fetch_node(uint i) { return nodes[i]; }
Primitive fetch_primitive(uint slot) { return primitives[slot]; }
Shape fetch_shape(uint i) { return shapes[i]; }
LightShape fetch_light_shape(uint i) { return light_shapes[i]; }
LightPrimitive fetch_light_primitive(uint i) { return light_primitives[i]; }
// Vertex indices of a triangle in xyz; only for shapes with vertex normals.
uvec3 fetch_triangle(uint i) { return triangles[i].xyz; }
vec3 fetch_normal(uint i) { return normals[i].xyz; }
// Offset in pixels at u = i / kFilterSteps.
float fetch_filter_knot(uint i) { return filter_knots[i]; }

#endif
