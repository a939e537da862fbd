// Inputs and outputs of the test kernels, shared by C++ and GLSL under the layout rule of shaders/gpu_types.h.
#ifndef ETENDUE_TEST_TYPES_H
#define ETENDUE_TEST_TYPES_H

#include "gpu_types.h"

#ifdef __cplusplus
namespace etendue::gpu {
#endif

struct WordsCase {
  uint pixel, sample_index, block, seed;
};
struct WordsAnswer {
  uvec4 words;
  vec4 units;
};

const uint kWarpDisk = 0u;
const uint kWarpCosineHemisphere = 1u;
const uint kWarpTriangle = 2u;
const uint kWarpCone = 3u;    // parameter: 1 − cos of the half angle
const uint kWarpOctant = 4u;  // (cos, sin) of u.x, radians
const uint kWarpTurn = 5u;    // (cos, sin) of u.x turns
struct WarpCase {
  vec2 u;
  float parameter;
  uint warp;
};
struct WarpAnswer {
  vec3 value;
  uint pad0;
};

struct FresnelCase {
  float cos_o, eta;
  uint pad0, pad1;
};
struct FresnelAnswer {
  float reflectance, cos_t;
  uint pad0, pad1;
};

struct FrameCase {
  vec3 n;
  uint pad0;
  vec3 w;
  uint pad1;
};
struct FrameAnswer {
  vec3 s;
  uint pad0;
  vec3 t;
  uint pad1;
  vec3 local;
  uint pad2;
  vec3 world;  // local turned back
  uint pad3;
};

// One call of each function of the contract in bsdf.glsl; wi is for eval and pdf.
struct BsdfCase {
  vec3 albedo;
  uint header;  // kMaterial*
  float int_ior, ext_ior;
  vec2 u;
  vec3 wo;
  float u_lobe;
  vec3 wi;
  uint pad0;
};
struct BsdfAnswer {
  vec3 wi;
  float pdf;
  vec3 weight;
  uint lobe;
  vec3 eval_at_sample;
  float pdf_at_sample;
  vec3 eval;
  float eval_pdf;
  float eta_scale;
  uint is_delta, is_one_sided;
  uint pad0;
};

struct LightCase {
  vec3 p;
  uint pad0;
  uvec4 words;
  vec3 n;
  uint pad1;
};
struct LightAnswer {
  vec3 p;
  float pdf_w;
  vec3 wi;
  float mis_pdf;
  vec3 ng;
  float error;
  vec3 radiance;
  uint instance;
  uint primitive;
  uint pad0, pad1, pad2;
};

// One direction sampled by the words, and what direction w sees.
struct EnvironmentCase {
  uvec4 words;
  vec3 w;
  uint pad0;
};
struct EnvironmentAnswer {
  vec3 wi;
  float pdf_w;
  vec3 radiance;
  uint cell;
  vec3 seen;
  float seen_pdf_w;
  uint chosen;
  uint pad0, pad1, pad2;
};

struct RayCase {
  vec3 o;
  float t_min;
  vec3 d;
  float t_max;
};
// What light the ray meets and with which density light sampling would have found it.
struct EmissionAnswer {
  vec3 radiance;
  float pdf;
  uint instance, primitive;  // kNone: nothing hit
  float t;
  uint pad0;
};

struct IntersectCase {
  vec3 o;
  float t_min;
  vec3 d;
  float t_max;
  vec3 p0;
  uint kind;
  vec3 p1;
  uint pad0;
  vec3 p2;
  uint pad1;
};
struct IntersectAnswer {
  uint found;
  float t, b1, b2;
};

// The walk of the tree beside a loop over every primitive.
const uint kListed = 0xc000600du;  // in w of the vertex normals: x is a primitive's slot, see brute_force.glsl
struct TraceAnswer {
  float t;
  uint instance, primitive;  // kNone: no hit
  uint any;                  // 1 when the any-hit walk found something
  float brute_t;
  uint brute_instance, brute_primitive;
  uint ties;  // primitives at exactly brute_t
};

// A ray that hits something and a direction to leave to.
struct SpawnCase {
  vec3 o;
  uint pad0;
  vec3 d;
  uint pad1;
  vec3 wi;
  uint pad2;
};
struct SpawnAnswer {
  vec3 p;
  uint instance;  // kNone: the first ray hit nothing
  vec3 ng;
  uint primitive;
  float error;
  float t;  // of the second ray
  uint next_instance, next_primitive;
};

const uint kFilmSequence = 16u;  // samples that one lane adds to its slot
struct FilmCase {
  vec3 rgb;
  int exponent;
};

struct CameraCase {
  uint x, y;
  vec2 u;
  vec3 lens;
  uint pad0;
};
struct CameraAnswer {
  vec3 o;
  float t_min;
  vec3 d;
  float t_max;
  float weight;
  uint pad0, pad1, pad2;
};

struct LoopCase {
  uint rounds, pad0, pad1, pad2;
};
struct LoopAnswer {
  uint top_and_bottom;  // rounds counted by a loop that tests its exit at both ends
  uint bottom_only;     // by a loop that can only leave at its bottom
  uint nested;          // by two nested loops with exits at both ends
  uint pad0;
};

struct TextureCase {
  uint instance;
  uint primitive;
  uint pad0;
  uint pad1;
  vec3 weights;
  uint pad2;
  vec3 n;
  uint pad3;
};
struct TextureAnswer {
  vec4 value;
};

struct NormalsAnswer {
  vec4 n0, n1, n2;
};

// One entry of each table of the scene, as the kernels fetch it.
struct TablesAnswer {
  Record record;
  Instance instance;
  MaterialRecord material;
  MaterialTextures material_textures;
  TextureUse texture_use;
  LightInstance light_instance;
  LightPrimitive light_primitive;
  uvec4 light_threshold;  // x: that of the light primitive, fetched alone
  LightBounds left_bounds;
  LightPair light_pair;
  LightTrail light_trail;
  uvec4 vertex_normals;
  vec4 filter_knot;  // x
  Place place;
  vec4 place_again;  // xyz: its origin, w: that of the instance, each fetched alone
  TextureRecord texture_record;
  InstanceAttributes instance_attributes;
  vec4 attributes;
  uvec4 picture;
  vec4 transmittances;
  EnvironmentRow environment_row;
  uvec4 environment_search;
  EnvironmentTexel environment_texel;
  DeltaLight delta_light;
  uvec4 delta_light_threshold;  // x
};

#ifdef __cplusplus
static_assert(sizeof(TablesAnswer) == 928);
static_assert(sizeof(NormalsAnswer) == 48);
static_assert(sizeof(TextureCase) == 48 && sizeof(TextureAnswer) == 16);
static_assert(sizeof(WordsAnswer) == 32);
static_assert(sizeof(WarpCase) == 16 && sizeof(WarpAnswer) == 16);
static_assert(sizeof(FrameCase) == 32 && sizeof(FrameAnswer) == 64);
static_assert(sizeof(BsdfCase) == 64 && sizeof(BsdfAnswer) == 80);
static_assert(sizeof(LightCase) == 48 && sizeof(LightAnswer) == 80 && sizeof(EmissionAnswer) == 32);
static_assert(sizeof(RayCase) == 32 && sizeof(IntersectCase) == 80 && sizeof(TraceAnswer) == 32);
static_assert(sizeof(SpawnCase) == 48 && sizeof(SpawnAnswer) == 48);
static_assert(sizeof(FilmCase) == 16 && sizeof(CameraCase) == 32 && sizeof(CameraAnswer) == 48);
static_assert(sizeof(LoopCase) == 16 && sizeof(LoopAnswer) == 16);
}  // namespace etendue::gpu
#endif
#endif
