// Adapters between a surface and the materials that scatter there; docs/conventions.md, "Adapters".
#ifndef ADAPTERS_GLSL
#define ADAPTERS_GLSL

#include "frame.glsl"
#include "material_flags.glsl"
#include "mutants.h"
#include "sampler.glsl"
#include "scene.glsl"
#include "texture.glsl"

FEATURE(uint, kAdapterDepth, kConstantAdapterDepth, 0u)  // nesting depth
layout(constant_id = kConstantCountPasses) const bool kCountPasses = true;  // passing a surface ends a segment

#define adapter_is(header, type) ((kAdapters >> ((type) - kAdapterFirst) & 1u) != 0u && ((header) & kMaterialTypeMask) == (type))

// A chosen material, or an adapter on the way to it, and the frame in which it sees directions.
struct Choice {
  uint material;  // kNone: light passes the surface
  ShadingFrame frame;
  vec3 base;      // the normal before maps turned it, on the side that is looked at
  float side;     // of frame.n, against the normal of the surface
  bool shadowed;  // no map on the way disables the shadowing of turned normals
};

// The material that the first blend on the way did not choose.
struct OtherChoice {
  Choice choice;
  float share;  // the probability of the chosen one; below 0 if there was no blend
};

// The probability of an adapter at a point.
float adapter_number(uint row, MaterialRecord record, SurfacePoint at) {
  if (!kTextured || (record.header & kMaterialTextured) == 0u) return record.params.z;
  return record.params.z * scalar_factor(fetch_material_textures(row).first, at);
}

vec3 unit_or(vec3 v, vec3 otherwise) {
  const float largest = max_component(abs(v));
  return largest > 0.0 ? normalize(v / largest) : otherwise;
}

// The frame of an anisotropic material: s follows the first texture coordinate, if the surface has one.
ShadingFrame aligned_frame(vec3 n, SurfacePoint at, Primitive geometry) {
  const vec3 u = surface_tangents(at, geometry, 0u).u;
  const vec3 s = unit_or(u - n * dot(n, u), vec3(0.0));
  if (s == vec3(0.0)) return make_frame(n);
  return ShadingFrame(s, cross(n, s), n);
}

// The normal from a normal map applied to n, which is the normal of the surface or, with side −1, its opposite; u is
// the direction of increasing texture coordinates.
vec3 normal_by_picture(uint index, vec3 u, vec3 n, float side, SurfacePoint at) {
  if (u == vec3(0.0)) return n;
  const vec3 t = unit_or(u - n * dot(n, u), vec3(0.0));
  const vec3 c = 2.0 * texture_value(index, at).xyz - 1.0;
  vec3 b = cross(side * n, t);
  MUTATE(kMutantNormalMapMirrored, b = -b);
  return unit_or(t * c.x + b * c.y + n * c.z, n);
}

// The same, with vertex tangents.
vec3 normal_by_vertices(uint index, vec3 n, float side, SurfacePoint at) {
  const vec4 tangent = vertex_tangent(at);
  return normal_by_picture(index, tangent.xyz, n, tangent.w < 0.0 ? -side : side, at);
}

// The normal from a map applied to n.
vec3 mapped_normal(uint row, MaterialRecord record, vec3 n, float side, SurfacePoint at, Primitive geometry) {
  const uint texture_of = fetch_material_textures(row).first;
  const uint index = texture_of & kTextureOfIndexMask;
  const bool picture = adapter_is(record.header, kAdapterNormalMap);
  if (textures_have(kTexturesVertexTangents) && picture && (uint(record.params.y) & kMapVertexTangents) != 0u) return normal_by_vertices(index, n, side, at);
  const Tangents d = surface_tangents(at, geometry, fetch_texture(index).uv_set);
  if (picture) return normal_by_picture(index, d.u, n, side, at);
  if (d.u == vec3(0.0)) return n;
  const vec2 slope = bitmap_gradient(texture_of, at) * (record.params.z * frame.distance_scale);
  const vec3 m = unit_or(cross(d.u + n * (slope.x - dot(n, d.u)), d.v + n * (slope.y - dot(n, d.v))), n);
  return dot(m, n) < 0.0 ? -m : m;
}

// A normal that faces away from the side on which the surface is seen.
vec3 seen_normal(vec3 mapped, vec3 n, vec3 w) { return dot(mapped, w) * dot(n, w) <= 0.0 ? n * (2.0 * dot(n, mapped)) - mapped : mapped; }

// The normal of a coat that keeps its own normal, whatever maps apply to the base.
vec3 coat_normal(Choice choice, SurfacePoint at, Primitive geometry, vec3 w) {
  const vec3 n = choice.base;
  uint map = kNone;
  if (kTextured) map = fetch_material_textures(choice.material).coat_normals;
  MUTATE(kMutantCoatNormalsIgnored, map = kNone);
  if (map == kNone) return n;
  const uint index = map & kTextureOfIndexMask;
  vec3 mapped;
  if (textures_have(kTexturesVertexTangents) && (map & kTextureOfVertexTangents) != 0u) mapped = normal_by_vertices(index, n, choice.side, at);
  else mapped = normal_by_picture(index, surface_tangents(at, geometry, fetch_texture(index).uv_set).u, n, choice.side, at);
  return seen_normal(mapped, n, w);
}

// Follows an adapter to a material. `w` points away from the surface, to the side from which it is seen; `words` are those of choice_words().
void go_to_material(inout Choice choice, inout OtherChoice other, SurfacePoint at, Primitive geometry, vec3 w, uvec4 words) {
  for (uint i = 0u; i <= kAdapterDepth; ++i) {
    const MaterialRecord record = fetch_material(choice.material, 1u);
    const uint first = uint(record.params.x), second = uint(record.params.y);
    uint next = kNone;
    if (adapter_is(record.header, kAdapterTwoSided)) {
      const bool behind = dot(w, choice.frame.n) < 0.0;
      next = behind ? second : first;
      MUTATE(kMutantSidesSwapped, next = behind ? first : second);
      if (behind) {
        choice.frame.n = -choice.frame.n;
        choice.base = -choice.base;
        choice.side = -choice.side;
      }
    }
    if (kPerturbed && (adapter_is(record.header, kAdapterNormalMap) || adapter_is(record.header, kAdapterBumpMap))) {
      const vec3 n = choice.frame.n;
      uint bits = kLooseMaps ? second : 0u;
      MUTATE(kMutantLooseMapsTied, bits = 0u);
      const vec3 mapped = mapped_normal(choice.material, record, n, choice.side, at, geometry);
      choice.frame = make_frame((bits & kMapUnmirrored) != 0u ? mapped : seen_normal(mapped, n, w));
      choice.shadowed = choice.shadowed && (bits & kMapUnshadowed) == 0u;
      next = first;
    }
    if (adapter_is(record.header, kAdapterMask)) {
      next = choice_number(words, choice.material) < adapter_number(choice.material, record, at) ? first : kNone;
    }
    if (adapter_is(record.header, kAdapterBlend)) {
      const float weight = clamp(adapter_number(choice.material, record, at), 0.0, 1.0);
      bool chosen = choice_number(words, choice.material) < weight;
      if (other.share < 0.0) {
        other = OtherChoice(choice, chosen ? weight : 1.0 - weight);
        other.choice.material = chosen ? first : second;
      }
      MUTATE(kMutantBlendSwapped, chosen = !chosen);
      next = chosen ? second : first;
    }
    const uint type = record.header & kMaterialTypeMask;
    if (type < kAdapterFirst) {
      if (kPassable && type == kBsdfNull) choice.material = kNone;
      break;
    }
    choice.material = next;
    if (next == kNone) break;
  }
}

Choice choose_material(uint row, ShadingFrame surface_frame, SurfacePoint at, Primitive geometry, vec3 w, uvec4 words, out OtherChoice other) {
  Choice choice = Choice(row, surface_frame, surface_frame.n, 1.0, true);
  other = OtherChoice(choice, -1.0);
  go_to_material(choice, other, at, geometry, w, words);
  return choice;
}

#endif
