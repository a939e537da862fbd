// Textures at a point: docs/conventions.md, "Textures". Filtering is done here, from the texels as stored, so that
// every device and the reference use the same texels with the same weights.
#ifndef TEXTURE_GLSL
#define TEXTURE_GLSL

#include "features.glsl"
#include "math.glsl"
#include "mutants.h"
#include "scene.glsl"

FEATURE(uint, kTextureFeatures, kConstantTextureFeatures, 0u)
const bool kTextured = kTextureFeatures != 0u;

#define textures_have(feature) ((kTextureFeatures & (feature)) != 0u)

// A point of a surface, as needed to interpolate its attributes.
struct SurfacePoint {
  uint instance;
  uint primitive;
  vec3 weights;  // of the triangle's corners; of a disk's centre and the ends of its half axes; of the ends of a cylinder's axis
  vec3 n;        // on a sphere the direction from its centre, on a cylinder the normal
};

// (b, a) shifted right by `bits` < 32: the low word.
uint funnel(uint a, uint b, uint bits) { return a >> bits | (b << 1u) << (31u - bits); }

// The bytes of a texel, `at` bytes after the start of the 16-byte unit `first`; the bytes after the texel are
// undefined.
uvec4 load_texel(uint first, uint at, uint bytes) {
  const uvec4 a = fetch_picture(first + at / 16u);
  uvec4 b = a;
  if (textures_have(kTexturesThreeChannels)) b = fetch_picture(first + (at + bytes - 1u) / 16u);
  // Shifted by 4 bytes, then by 8 bytes, then by bits.
  const bool odd = (at & 4u) != 0u, upper = (at & 8u) != 0u;
  const uvec4 c = odd ? uvec4(a.yzw, b.x) : a, d = odd ? uvec4(b.yzw, 0u) : b;
  const uvec4 e = upper ? uvec4(c.zw, d.xy) : c;
  const uint bits = 8u * (at & 3u);
  return uvec4(funnel(e.x, e.y, bits), funnel(e.y, e.z, bits), funnel(e.z, e.w, bits), e.w);
}

// The numbers of a texel as stored: 8-bit codes as 0 … 255.
vec4 unpack_texel(uvec4 raw, uint format) {
  const vec4 bytes = vec4(raw.x & 255u, raw.x >> 8u & 255u, raw.x >> 16u & 255u, raw.x >> 24u);
  const vec4 halves = vec4(unpackHalf2x16(raw.x), unpackHalf2x16(raw.y));
  return format == 0u ? bytes : format == 1u ? halves : uintBitsToFloat(raw);
}

// Linear value of 8-bit sRGB codes, given as 0 … 1: IEC 61966-2-1. x^2.4 is x² · x^0.4, with x^0.4 a polynomial in the
// root of x, fitted to the 245 codes that need it with an error of 1.2e-7 of the value; tables would take three loads
// per texel.
vec3 light_of_codes(vec3 v) {
  const vec3 x = (v + 0.055) * (1.0 / 1.055);
  const vec3 s = sqrt(x);
  vec3 p = vec3(-0.195132479);
  p = p * s + 1.14607155;
  p = p * s - 2.96589470;
  p = p * s + 4.46358490;
  p = p * s - 4.35862970;
  p = p * s + 2.95424557;
  p = p * s - 1.54290783;
  p = p * s + 1.47357821;
  p = p * s + 0.0250843186;
  return mix(x * x * p, v * (1.0 / 12.92), lessThanEqual(v, vec3(0.04045)));
}

// Red, green, blue and alpha of the texel in column x and row y.
vec4 texel(TextureRecord t, uint x, uint y) {
  const uint channels = t.header >> kTextureChannelsShift & kTextureChannelsMask;
  const uint format = t.header >> kTextureFormatShift & kTextureFormatMask;
  const uint bytes = channels << format;
  vec4 v = unpack_texel(load_texel(t.first, (y * t.width + x) * bytes, bytes), format);
  if (channels < 3u) v = vec4(v.xxx, v.y);
  if (format == 0u) {
    v *= 1.0 / 255.0;
    bool coded = textures_have(kTexturesSrgb) && (t.header & kTextureSrgb) != 0u;
    MUTATE(kMutantSrgbLeftOut, coded = false);
    if (coded) v.xyz = light_of_codes(v.xyz);
  }
  v.w = channels == 2u || channels == 4u ? v.w : 1.0;
  return v;
}

// A texture coordinate reduced to one period of its wrap mode: a subtraction that is exact, except for tiny negative ones, for any size.
float into_period(float u, uint wrap) {
  if (wrap == kTextureWrapRepeat) return u - floor(u);
  if (wrap == kTextureWrapMirror) return u - 2.0 * floor(0.5 * u);
  return clamp(u, 0.0, 1.0);
}

// The texel at position i of a row of n, for i from −1 to one past the period.
uint wrap_texel(int i, int n, uint wrap) {
  MUTATE(kMutantWrapOffByOne, i = i >= n && wrap == kTextureWrapRepeat ? n - 1 : i);
  if (wrap == kTextureWrapRepeat) i = i < 0 ? i + n : i >= n ? i - n : i;
  if (wrap == kTextureWrapMirror) {
    i = i < 0 ? -1 - i : i >= 2 * n ? i - 2 * n : i;
    i = i >= n ? 2 * n - 1 - i : i;
  }
  return uint(clamp(i, 0, n - 1));
}

vec4 bitmap_value(TextureRecord t, vec2 uv) {
  const uint wrap_u = t.header >> kTextureWrapUShift & kTextureWrapMask, wrap_v = t.header >> kTextureWrapVShift & kTextureWrapMask;
  MUTATE(kMutantRowsSwapped, uv.y = 1.0 - uv.y);
  const ivec2 size = ivec2(t.width, t.height);
  const vec2 place = vec2(into_period(uv.x, wrap_u), into_period(uv.y, wrap_v)) * vec2(size);
  const bool bilinear = textures_have(kTexturesBilinear) && (t.header & kTextureBilinear) != 0u;
  // Texel i covers [i, i + 1) and has its centre at i + 1/2.
  vec2 shifted = bilinear ? place - 0.5 : place;
  MUTATE(kMutantHalfTexel, shifted = place);
  const vec2 lower = floor(shifted);
  const uint x0 = wrap_texel(int(lower.x), size.x, wrap_u), y0 = wrap_texel(int(lower.y), size.y, wrap_v);
  const vec4 v00 = texel(t, x0, y0);
  if (!bilinear) return v00;
  const uint x1 = wrap_texel(int(lower.x) + 1, size.x, wrap_u), y1 = wrap_texel(int(lower.y) + 1, size.y, wrap_v);
  const vec2 f = shifted - lower;
  return mix(mix(v00, texel(t, x1, y0), f.x), mix(texel(t, x0, y1), texel(t, x1, y1), f.x), f.y);
}

// Whether a position is in a square of the first colour.
bool is_even_square(vec2 uv) {
  const vec2 cell = uv - floor(uv);
  return (cell.x >= 0.5) == (cell.y >= 0.5);
}

vec4 checkerboard_value(TextureRecord t, vec2 uv) { return vec4(is_even_square(uv) ? t.color0 : t.color1, 1.0); }

// Texels of the attributes of a primitive.
uint attribute_stride(uint layout_bits) {
  return 2u * (layout_bits & kAttributesSetsMask) + ((layout_bits & kAttributesVertexColors) != 0u ? 3u : 0u) +
         ((layout_bits & kAttributesFaceColors) != 0u ? 1u : 0u) +
         (textures_have(kTexturesVertexTangents) && (layout_bits & kAttributesTangents) != 0u ? 3u : 0u);
}

// Texture coordinates of the surface. On a sphere u is the angle around its z axis from x toward y, as a fraction of a
// turn, v the angle from −z divided by π; on a disk u is the distance from its centre, 1 − v the angle; on a cylinder u
// is the angle around its axis, 1 − v the position along it.
vec2 surface_uv(InstanceAttributes a, SurfacePoint at, uint set) {
  if (textures_have(kTexturesSphere) && (a.layout_bits & kAttributesSphere) != 0u) {
    const vec3 d = vec3(dot(fetch_attribute(a.first).xyz, at.n), dot(fetch_attribute(a.first + 1u).xyz, at.n),
                        dot(fetch_attribute(a.first + 2u).xyz, at.n));
    return vec2(turn_of(d.x, d.y), 2.0 * turn_of(-d.z, length(d.xy)));
  }
  if (textures_have(kTexturesDisk) && (a.layout_bits & kAttributesDisk) != 0u) {
    vec2 d = (a.layout_bits & kAttributesTurned) != 0u ? at.weights.zy : at.weights.yz;
    MUTATE(kMutantDiskTurnReversed, d.y = -d.y);
    return vec2(length(d), 1.0 - turn_of(d.x, d.y));
  }
  if (textures_have(kTexturesCylinder) && (a.layout_bits & kAttributesCylinder) != 0u) {
    const float around = turn_of(dot(fetch_attribute(a.first).xyz, at.n), dot(fetch_attribute(a.first + 1u).xyz, at.n));
    MUTATE(kMutantCylinderUpsideDown, return vec2(around, at.weights.y));
    return vec2(around, at.weights.x);
  }
  const uint stride = attribute_stride(a.layout_bits);
  const uint first = a.first + stride * at.primitive + 2u * set;
  const vec4 corners = fetch_attribute(first);
  return at.weights.x * corners.xy + at.weights.y * corners.zw + at.weights.z * fetch_attribute(first + 1u).xy;
}

vec4 attribute_value(InstanceAttributes a, SurfacePoint at, uint kind) {
  uint first = a.first + attribute_stride(a.layout_bits) * at.primitive + 2u * (a.layout_bits & kAttributesSetsMask);
  if (kind == kTextureFaceColor) return vec4(fetch_attribute(first + ((a.layout_bits & kAttributesVertexColors) != 0u ? 3u : 0u)).xyz, 1.0);
  return at.weights.x * fetch_attribute(first) + at.weights.y * fetch_attribute(first + 1u) + at.weights.z * fetch_attribute(first + 2u);
}

// The tangent of the vertices, interpolated; w < 0: the bitangent is the opposite of normal × tangent.
vec4 vertex_tangent(SurfacePoint at) {
  const InstanceAttributes a = fetch_instance_attributes(at.instance);
  const uint stride = attribute_stride(a.layout_bits), first = a.first + stride * (at.primitive + 1u) - 3u;
  vec4 t = at.weights.x * fetch_attribute(first) + at.weights.y * fetch_attribute(first + 1u) + at.weights.z * fetch_attribute(first + 2u);
  const uint place_index = kInstanced ? fetch_instance_place(at.instance) : kNone;
  if (place_index != kNone) {
    const Place place = fetch_place(place_index);
    t = vec4(place.x * t.x + place.y * t.y + place.z * t.z, t.w * place.side);
  }
  return t;
}

// A picture or checkerboard at texture coordinates (u, v, 1) of its surface.
vec4 texture_at(TextureRecord t, vec3 surface) {
  vec2 uv = vec2(dot(t.u_row, surface), dot(t.v_row, surface));
  if (textures_have(kTexturesNested)) {
    // Descends into the squares of checkerboards, which contain only textures of earlier rows.
    vec3 factor = vec3(1.0);
    while ((t.header & kTextureKindMask) == kTextureCheckerboard) {
      const bool even = is_even_square(uv);
      uint within = even ? t.first : t.width;
      MUTATE(kMutantSquaresSwapped, within = even ? t.width : t.first);
      if (within == kNone) break;
      factor *= even ? t.color0 : t.color1;
      t = fetch_texture(within);
      uv = vec2(dot(t.u_row, surface), dot(t.v_row, surface));
    }
    const bool board = (t.header & kTextureKindMask) == kTextureCheckerboard;
    return vec4(factor, 1.0) * (board ? checkerboard_value(t, uv) : bitmap_value(t, uv));
  }
  MUTATE(kMutantUvTransformInverted, uv = inverse(mat2(t.u_row.x, t.v_row.x, t.u_row.y, t.v_row.y)) * (surface.xy - vec2(t.u_row.z, t.v_row.z)));
  if (textures_have(kTexturesCheckerboard) && (t.header & kTextureKindMask) == kTextureCheckerboard) return checkerboard_value(t, uv);
  return textures_have(kTexturesBitmap) ? bitmap_value(t, uv) : vec4(0.0);
}

// Applies the flags of a texture to its value.
vec4 derived_value(TextureRecord t, vec4 value, InstanceAttributes a, SurfacePoint at) {
  MUTATE(kMutantVertexTintLeftOut, t.header &= ~kTextureTinted);
  MUTATE(kMutantAlphaNotMultiplied, t.header &= ~kTexturePremultiplied);
  if (textures_have(kTexturesTinted) && (t.header & kTextureTinted) != 0u) value *= attribute_value(a, at, kTextureVertexColor);
  if (textures_have(kTexturesAlpha)) {
    if ((t.header & kTextureCut) != 0u) value.w = value.w >= t.cutoff ? 1.0 : 0.0;
    if ((t.header & kTexturePremultiplied) != 0u) value.xyz *= value.w;
  }
  return value;
}

vec4 texture_value(uint index, SurfacePoint at) {
  const TextureRecord t = fetch_texture(index);
  const InstanceAttributes a = fetch_instance_attributes(at.instance);
  const uint kind = t.header & kTextureKindMask;
  vec4 value;
  if (textures_have(kTexturesAttribute) && kind >= kTextureVertexColor) value = attribute_value(a, at, kind);
  else value = texture_at(t, vec3(surface_uv(a, at, t.uv_set), 1.0));
  return derived_value(t, value, a, at);
}

// The factor of a parameter: 1 if it has no texture.
vec3 color_factor(uint texture_of, SurfacePoint at) { return texture_of == kNone ? vec3(1.0) : texture_value(texture_of & kTextureOfIndexMask, at).xyz; }

float channel_of(vec4 value, uint texture_of) {
  const uint channel = texture_of >> kTextureOfChannelShift;
  return channel > 3u ? luminance(value.xyz) : value[channel];
}

float scalar_factor(uint texture_of, SurfacePoint at) {
  return texture_of == kNone ? 1.0 : channel_of(texture_value(texture_of & kTextureOfIndexMask, at), texture_of);
}

// The same as four numbers: a number in each of them, a colour in the first three.
vec4 texture_factor(uint texture_of, SurfacePoint at) {
  const vec4 value = texture_value(texture_of & kTextureOfIndexMask, at);
  return texture_of >> kTextureOfChannelShift == kTextureOfColor ? vec4(value.xyz, 1.0) : vec4(channel_of(value, texture_of));
}

// The derivative of a number of a picture with respect to the surface's texture coordinates: the slope of its bilinear interpolation, whatever the
// filter.
vec2 bitmap_gradient(uint texture_of, SurfacePoint at) {
  const TextureRecord t = fetch_texture(texture_of & kTextureOfIndexMask);
  const vec3 surface = vec3(surface_uv(fetch_instance_attributes(at.instance), at, t.uv_set), 1.0);
  const uint wrap_u = t.header >> kTextureWrapUShift & kTextureWrapMask, wrap_v = t.header >> kTextureWrapVShift & kTextureWrapMask;
  const vec2 place = vec2(into_period(dot(t.u_row, surface), wrap_u), into_period(dot(t.v_row, surface), wrap_v)) * vec2(t.width, t.height);
  const vec2 lower = floor(place - 0.5), f = place - 0.5 - lower;
  const uint x0 = wrap_texel(int(lower.x), int(t.width), wrap_u), x1 = wrap_texel(int(lower.x) + 1, int(t.width), wrap_u);
  const uint y0 = wrap_texel(int(lower.y), int(t.height), wrap_v), y1 = wrap_texel(int(lower.y) + 1, int(t.height), wrap_v);
  const float c00 = channel_of(texel(t, x0, y0), texture_of), c10 = channel_of(texel(t, x1, y0), texture_of);
  const float c01 = channel_of(texel(t, x0, y1), texture_of), c11 = channel_of(texel(t, x1, y1), texture_of);
  vec2 g = vec2(mix(c10 - c00, c11 - c01, f.y), mix(c01 - c00, c11 - c10, f.x)) * vec2(t.width, t.height);
  MUTATE(kMutantBumpByTexel, g /= vec2(t.width, t.height));
  return vec2(g.x * t.u_row.x + g.y * t.v_row.x, g.x * t.u_row.y + g.y * t.v_row.y);
}

// The derivative of the surface point with respect to its texture coordinates.
struct Tangents {
  vec3 u, v;  // 0 where the coordinates are degenerate
};

Tangents sphere_tangents(InstanceAttributes a, SurfacePoint at, float radius) {
  const vec3 x = fetch_attribute(a.first).xyz, y = fetch_attribute(a.first + 1u).xyz, z = fetch_attribute(a.first + 2u).xyz;
  const vec3 d = vec3(dot(x, at.n), dot(y, at.n), dot(z, at.n));
  const float r = length(d.xy);
  if (r == 0.0) return Tangents(vec3(0.0), vec3(0.0));
  const vec2 around = d.xy / r;
  return Tangents((2.0 * kPi * radius) * (x * -d.y + y * d.x), (kPi * radius) * (z * r - (x * around.x + y * around.y) * d.z));
}

Tangents disk_tangents(InstanceAttributes a, SurfacePoint at, Primitive geometry) {
  const bool turned = (a.layout_bits & kAttributesTurned) != 0u;
  const vec3 p1 = geometry.p1 - geometry.p0, p2 = geometry.p2 - geometry.p0;
  const vec3 x = turned ? p2 : p1, y = turned ? p1 : p2;
  const vec2 d = turned ? at.weights.zy : at.weights.yz;
  const float r = length(d);
  if (r == 0.0) return Tangents(vec3(0.0), vec3(0.0));
  return Tangents((d.x * x + d.y * y) / r, (2.0 * kPi) * (d.y * x - d.x * y));
}

Tangents cylinder_tangents(InstanceAttributes a, SurfacePoint at, Primitive geometry) {
  const vec3 x = fetch_attribute(a.first).xyz, y = fetch_attribute(a.first + 1u).xyz;
  const vec3 around = y * dot(x, at.n) - x * dot(y, at.n);
  return Tangents((2.0 * kPi * geometry.p2.x * geometry.p2.y) * around, geometry.p0 - geometry.p1);
}

// `geometry` is the primitive in the world.
Tangents surface_tangents(SurfacePoint at, Primitive geometry, uint set) {
  const InstanceAttributes a = fetch_instance_attributes(at.instance);
  if (textures_have(kTexturesSphere) && (a.layout_bits & kAttributesSphere) != 0u) {
    return sphere_tangents(a, at, geometry.p1.y == 0.0 ? geometry.p1.x : -geometry.p1.x);  // for an inward one, both its rows and its normal are reversed
  }
  if (textures_have(kTexturesDisk) && (a.layout_bits & kAttributesDisk) != 0u) return disk_tangents(a, at, geometry);
  if (textures_have(kTexturesCylinder) && (a.layout_bits & kAttributesCylinder) != 0u) return cylinder_tangents(a, at, geometry);
  if ((a.layout_bits & kAttributesSetsMask) == 0u) return Tangents(vec3(0.0), vec3(0.0));
  const uint first = a.first + attribute_stride(a.layout_bits) * at.primitive + 2u * set;
  const vec4 corners = fetch_attribute(first);
  const vec2 d1 = corners.zw - corners.xy, d2 = fetch_attribute(first + 1u).xy - corners.xy;
  const float det = d1.x * d2.y - d1.y * d2.x;
  if (det == 0.0) return Tangents(vec3(0.0), vec3(0.0));
  const vec3 e1 = geometry.p1 - geometry.p0, e2 = geometry.p2 - geometry.p0;
  return Tangents((d2.y * e1 - d1.y * e2) / det, (d1.x * e2 - d2.x * e1) / det);
}

#endif
