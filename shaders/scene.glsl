// The only file with descriptor bindings of the scene: typed fetch functions for everything the host uploaded.
#ifndef SCENE_GLSL
#define SCENE_GLSL

// Texel buffers are images without samplers; declaring them with one is an error by newer rules of SPIR-V.
#extension GL_EXT_samplerless_texture_functions : require

#include "features.glsl"
#include "gpu_types.h"

layout(set = kSetKernel, binding = kBindingFrame, std140) uniform FrameBlock { Frame frame; };
// load_<buffer>(i): 16 bytes of a buffer of tables. Tables are read through texel buffers: one 128-bit load per texel, where storage buffers are
// loaded word by word (lavapipe); the texture cache on GPUs; and up to 2^27 texels, where a storage buffer may end at 128 MiB. A second build reads
// storage buffers, for devices whose texel buffers are too short.
#ifdef ETENDUE_STORAGE_TABLES
#define TABLE(name, table_binding)                                                                                         \
  layout(set = kSetScene, binding = table_binding, std430) readonly buffer name##_block { uvec4 name##_quads[]; };                 \
  uvec4 load_##name(uint i) { return name##_quads[i]; }
#else
#define TABLE(name, table_binding)                                       \
  layout(set = kSetScene, binding = table_binding) uniform utextureBuffer name##_texels; \
  uvec4 load_##name(uint i) { return texelFetch(name##_texels, int(i)); }
#endif
TABLE(record, kBindingRecords)
TABLE(geometry, kBindingGeometry)
TABLE(table, kBindingTables)
#ifdef ETENDUE_RAY_QUERY
#extension GL_EXT_ray_query : require
layout(set = kSetScene, binding = kBindingStructure) uniform accelerationStructureEXT scene_structure;
#endif
// Start of each table, in texels. The vertex normals come first in the geometry, the instances first in the tables.
layout(constant_id = kConstantMaterialsAt) const uint kMaterialsAt = 0u;
layout(constant_id = kConstantMaterialTexturesAt) const uint kMaterialTexturesAt = 0u;
layout(constant_id = kConstantTextureUsesAt) const uint kTextureUsesAt = 0u;
layout(constant_id = kConstantTexturesAt) const uint kTexturesAt = 0u;
layout(constant_id = kConstantInstanceAttributesAt) const uint kInstanceAttributesAt = 0u;
layout(constant_id = kConstantAttributesAt) const uint kAttributesAt = 0u;
layout(constant_id = kConstantTexelsAt) const uint kTexelsAt = 0u;
layout(constant_id = kConstantTransmittancesAt) const uint kTransmittancesAt = 0u;
layout(constant_id = kConstantLightInstancesAt) const uint kLightInstancesAt = 0u;
layout(constant_id = kConstantLightPrimitivesAt) const uint kLightPrimitivesAt = 0u;
layout(constant_id = kConstantLightPairsAt) const uint kLightPairsAt = 0u;
layout(constant_id = kConstantLightTrailsAt) const uint kLightTrailsAt = 0u;
layout(constant_id = kConstantDeltaLightsAt) const uint kDeltaLightsAt = 0u;
layout(constant_id = kConstantPlacesAt) const uint kPlacesAt = 0u;
FEATURE(bool, kInstanced, kConstantInstanced, false)  // some meshes are shared, see kRecordInstance
layout(constant_id = kConstantEnvironmentRowsAt) const uint kEnvironmentRowsAt = 0u;
layout(constant_id = kConstantEnvironmentTexelsAt) const uint kEnvironmentTexelsAt = 0u;
layout(constant_id = kConstantEnvironmentSearchAt) const uint kEnvironmentSearchAt = 0u;
layout(set = kSetKernel, binding = kBindingFilter) uniform textureBuffer filter_knots;

// A primitive, or the first three texels of a node.
Record fetch_record(uint slot) {
  const uint i = kSlotTexels * slot;
  return Record(load_record(i), load_record(i + 1u), load_record(i + 2u));
}
Primitive to_primitive(Record r) {
  return Primitive(uintBitsToFloat(r.a.xyz), r.a.w, uintBitsToFloat(r.b.xyz), r.b.w, uintBitsToFloat(r.c.xyz), r.c.w);
}
Instance fetch_instance(uint i) {
  const uint first = kInstanceTexels * i;
  const uvec4 a = load_table(first);
  const uvec4 b = load_table(first + 1u);
  return Instance(uintBitsToFloat(a.xyz), uintBitsToFloat(a.w), b.x, b.y, uintBitsToFloat(b.z), b.w);
}
uint fetch_instance_place(uint i) { return load_table(kInstanceTexels * i + 1u).w; }
Place fetch_place(uint i) {
  const uint first = kPlacesAt + kPlaceTexels * i;
  const uvec4 o = load_table(first), x = load_table(first + 1u), y = load_table(first + 2u), z = load_table(first + 3u);
  const uvec4 a = load_table(first + 4u), b = load_table(first + 5u), c = load_table(first + 6u);
  return Place(uintBitsToFloat(o.xyz), uintBitsToFloat(o.w), uintBitsToFloat(x.xyz), uintBitsToFloat(x.w), uintBitsToFloat(y.xyz), uintBitsToFloat(y.w),
               uintBitsToFloat(z.xyz), uintBitsToFloat(z.w), uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), c.w);
}
vec3 fetch_place_origin(uint i) { return uintBitsToFloat(load_table(kPlacesAt + kPlaceTexels * i).xyz); }
// Its first texels: 1, kRichMaterialTexels or kMaterialTexels.
MaterialRecord fetch_material(uint i, uint texels) {
  const uint first = kMaterialsAt + kMaterialTexels * i;
  const uvec4 a = load_table(first);
  vec4 more[7] = vec4[7](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
  if (texels >= kRichMaterialTexels)
    for (uint k = 0u; k < kRichMaterialTexels - 1u; ++k) more[k] = uintBitsToFloat(load_table(first + 1u + k));
  if (texels == kMaterialTexels)
    for (uint k = kRichMaterialTexels - 1u; k < kMaterialTexels - 1u; ++k) more[k] = uintBitsToFloat(load_table(first + 1u + k));
  return MaterialRecord(uintBitsToFloat(a.xyz), a.w, more[0].xyz, more[0].w, more[1].xyz, more[1].w, more[2].xyz, more[2].w, more[3], more[4], more[5], more[6]);
}
MaterialTextures fetch_material_textures(uint i) {
  const uvec4 a = load_table(kMaterialTexturesAt + i);
  return MaterialTextures(a.x, a.y, a.z, a.w);
}
TextureUse fetch_texture_use(uint i) {
  const uvec4 a = load_table(kTextureUsesAt + i);
  return TextureUse(a.x, a.y, uintBitsToFloat(a.z), uintBitsToFloat(a.w));
}
TextureRecord fetch_texture(uint i) {
  const uint first = kTexturesAt + kTextureRecordTexels * i;
  const uvec4 a = load_table(first), b = load_table(first + 1u), c = load_table(first + 2u), d = load_table(first + 3u), e = load_table(first + 4u);
  return TextureRecord(a.x, a.y, a.z, a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), uintBitsToFloat(c.w), uintBitsToFloat(d.xyz),
                       d.w, uintBitsToFloat(e.xyz), e.w);
}
InstanceAttributes fetch_instance_attributes(uint i) {
  const uvec4 a = load_table(kInstanceAttributesAt + kInstanceAttributesTexels * i);
  return InstanceAttributes(a.x, a.y, a.z, a.w);
}
vec4 fetch_attribute(uint i) { return uintBitsToFloat(load_geometry(kAttributesAt + i)); }
// 16 bytes of the pictures.
uvec4 fetch_picture(uint i) { return load_geometry(kTexelsAt + i); }
vec4 fetch_transmittances(uint i) { return uintBitsToFloat(load_table(kTransmittancesAt + i)); }
LightInstance fetch_light_instance(uint i) {
  const uvec4 a = load_table(kLightInstancesAt + kLightInstanceTexels * i);
  return LightInstance(a.x, a.y, a.z, a.w);
}
LightPrimitive fetch_light_primitive(uint i) {
  const uint first = kLightPrimitivesAt + kLightPrimitiveTexels * i;
  const Record r = Record(load_table(first), load_table(first + 1u), load_table(first + 2u));
  const uvec4 a = load_table(first + kRecordTexels);
  return LightPrimitive(to_primitive(r), a.x, uintBitsToFloat(a.y), a.z, a.w);
}
uint fetch_light_primitive_threshold(uint i) { return load_table(kLightPrimitivesAt + kLightPrimitiveTexels * i + kRecordTexels).x; }
// `first` is the first texel of one half of a pair, counted from the first pair.
LightBounds fetch_light_bounds(uint texel) {
  const uvec4 a = load_table(kLightPairsAt + texel);
  const uvec4 b = load_table(kLightPairsAt + texel + 1u);
  return LightBounds(uintBitsToFloat(a.xyz), uintBitsToFloat(a.w), uintBitsToFloat(b.xyz), uintBitsToFloat(b.w));
}
LightPair fetch_light_pair(uint i) {
  const uint left = kLightPairTexels * i;
  const uint right = left + kLightBoundsTexels;
  const uvec4 e = load_table(kLightPairsAt + right + kLightBoundsTexels);
  return LightPair(fetch_light_bounds(left), fetch_light_bounds(right), uintBitsToFloat(e.x), uintBitsToFloat(e.y), e.z, e.w);
}
LightTrail fetch_trail(uint i) {
  const uvec4 a = load_table(kLightTrailsAt + kLightTrailTexels * i);
  return LightTrail(a.x, uintBitsToFloat(a.y), a.z, a.w);
}
// Of the first primitive of an instance; 0 if it has none.
uint fetch_first_trail(uint instance) { return load_table(kLightTrailsAt + kLightTrailTexels * instance).x; }
DeltaLight fetch_delta_light(uint i) {
  const uint first = kDeltaLightsAt + kDeltaLightTexels * i;
  const uvec4 a = load_table(first), b = load_table(first + 1u), c = load_table(first + 2u), d = load_table(first + 3u);
  const uvec4 e = load_table(first + 4u), f = load_table(first + 5u);
  return DeltaLight(uintBitsToFloat(a.xyz), uintBitsToFloat(a.w), uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), uintBitsToFloat(c.w),
                    uintBitsToFloat(d.xyz), uintBitsToFloat(d.w), uintBitsToFloat(e.xy), uintBitsToFloat(e.z), e.w, f.x, f.y, uintBitsToFloat(f.z), f.w);
}
uint fetch_delta_light_threshold(uint i) { return load_table(kDeltaLightsAt + kDeltaLightTexels * i + 5u).x; }
EnvironmentRow fetch_environment_row(uint i) {
  const uvec4 a = load_table(kEnvironmentRowsAt + kEnvironmentRowTexels * i);
  return EnvironmentRow(uintBitsToFloat(a.x), uintBitsToFloat(a.y), uintBitsToFloat(a.z), a.w);
}
uvec4 fetch_environment_search(uint i) { return load_table(kEnvironmentSearchAt + i); }
EnvironmentTexel fetch_environment_texel(uint i) {
  const uvec4 a = load_table(kEnvironmentTexelsAt + kEnvironmentTexelTexels * i);
  return EnvironmentTexel(uintBitsToFloat(a.xyz), a.w);
}
// Vertex normals of a triangle, as vertex_normals.glsl reads them; only for instances that have them.
uvec4 fetch_vertex_normals(uint i) { return load_geometry(i); }
// Offset in pixels at u = i / kFilterSteps.
float fetch_filter_knot(uint i) { return texelFetch(filter_knots, int(i)).x; }

#endif
