// Types, ids, binding numbers and limits shared by C++ and GLSL: defined once, used by both.
//
// Layout rule: every vec3 is followed by a 4-byte scalar, vec2 sits at multiples of 8, sizes are multiples of 16, no bool and no
// array of vec3. Then std430, std140 and the C++ compiler agree byte for byte; tests/unit/compile_layout.cpp checks it against the
// Offset decorations of the built SPIR-V.
#ifndef ETENDUE_GPU_TYPES_H
#define ETENDUE_GPU_TYPES_H

#ifdef __cplusplus
#include <cstdint>

#include <glm/glm.hpp>
namespace etendue::gpu {
using uint = std::uint32_t;
using vec2 = glm::vec2;
using vec3 = glm::vec3;
using vec4 = glm::vec4;
using uvec4 = glm::uvec4;
#endif

// Descriptor sets by lifetime. Set 0 lives as long as a scene is on a device and holds its tables, read by load_<…> of scene.glsl. Since a device
// need bind only a few buffers to a kernel, tables share them, each at an offset given by kConstant…At.
const uint kSetScene = 0u;
const uint kBindingRecords = 0u;   // the tree
const uint kBindingGeometry = 1u;  // looked up by triangle: vertex normals, attributes, pictures
const uint kBindingTables = 2u;    // all others: instances, materials, lights
const uint kBindingStructure = 3u; // the driver's acceleration structure, in kernels with ray queries; see trace_query.glsl
// Set 1 is bound for a dispatch: the view, and a film or requests and their results.
const uint kSetKernel = 1u;
const uint kBindingFrame = 0u;
const uint kBindingFilter = 1u;
const uint kBindingFilm = 2u;
const uint kBindingSetSums = 3u;
const uint kBindingSamples = 4u;
const uint kBindingReport = 5u;
const uint kBindingRequests = 6u;
const uint kBindingResults = 7u;

// Ids of specialization constants: kConstant<X> is that of the constant k<X> in GLSL, whatever kernel declares it.
const uint kConstantFilterKind = 0u;
const uint kConstantIntegrator = 1u;
const uint kConstantNee = 2u;
const uint kConstantMis = 3u;
const uint kConstantLuminance = 4u;
const uint kConstantStepsPerTurn = 5u;
const uint kConstantIterationsPerRound = 6u;
const uint kConstantTurnsPerRound = 7u;
const uint kConstantStackSize = 8u;
const uint kConstantHasSpheres = 9u;
const uint kConstantFewCount = 10u;
const uint kConstantFewSpheres = 11u;
const uint kConstantLightInstanceRounds = 12u;
const uint kConstantLightPrimitiveRounds = 13u;
const uint kConstantBsdfsUsed = 14u;
const uint kConstantVertexNormals = 15u;
const uint kConstantSphereLights = 16u;
const uint kConstantTreeRoot = 17u;
const uint kConstantLightTreeDepth = 18u;
const uint kConstantSetBits = 19u;
const uint kConstantMutant = 20u;  // see mutants.h
const uint kConstantAnyHit = 21u;
// Texel at which a table begins in its buffer; the first one of a buffer begins at 0.
const uint kConstantLightInstancesAt = 23u;
const uint kConstantLightPrimitivesAt = 24u;
const uint kConstantLightPairsAt = 25u;
const uint kConstantLightTrailsAt = 26u;
const uint kConstantMaterialsAt = 27u;
// What the scene's materials have in common, see bsdf.glsl.
const uint kConstantMaterialFlagsSome = 28u;
const uint kConstantMaterialFlagsAll = 29u;
const uint kConstantLightNormals = 30u;
// The environment, see emitter/environment.glsl.
const uint kConstantEnvironment = 31u;
const uint kConstantEnvironmentAlone = 32u;
const uint kConstantEnvironmentColumns = 33u;
const uint kConstantEnvironmentTexelRows = 34u;
const uint kConstantEnvironmentCellRows = 35u;
const uint kConstantEnvironmentRowsAt = 36u;
const uint kConstantEnvironmentTexelsAt = 37u;
const uint kConstantEnvironmentRowLevels = 38u;  // of the search for a row, see kSearchFan
const uint kConstantEnvironmentColumnLevels = 39u;
const uint kConstantCamera = 40u;
const uint kConstantHideEmitters = 41u;
const uint kConstantCameraWindow = 42u;
// Lights without extent, see emitter/delta.glsl.
const uint kConstantDeltaLights = 43u;    // kDelta…
const uint kConstantDeltaLightsAt = 44u;
const uint kConstantDistantLights = 45u;  // how many are infinitely far away
const uint kConstantInstanced = 46u;  // some meshes are shared: the tree has two levels
const uint kConstantPlacesAt = 47u;
const uint kConstantMaterialTexturesAt = 48u;
const uint kConstantTextureFeatures = 49u;  // kTextures…
const uint kConstantTexturesAt = 50u;
const uint kConstantInstanceAttributesAt = 51u;
const uint kConstantEnvironmentSearchAt = 52u;
const uint kConstantAttributesAt = 53u;
const uint kConstantTexelsAt = 54u;
const uint kConstantHasDisks = 55u;
const uint kConstantHasCylinders = 56u;
const uint kConstantFewDisks = 57u;
const uint kConstantFewCylinders = 58u;
const uint kConstantCylinderLights = 59u;
const uint kConstantTransmittancesAt = 60u;
const uint kConstantAdapters = 61u;       // see adapters.glsl
const uint kConstantAdapterDepth = 62u;
const uint kConstantCountPasses = 63u;
const uint kConstantLightPart = 64u;       // kLightPart…
const uint kConstantHideBackground = 65u;
const uint kConstantTwoSidedLights = 68u;  // some light emits on both sides
const uint kConstantInwardSpheres = 69u;
const uint kConstantTextureUsesAt = 66u;
const uint kConstantTextureUses = 67u;  // maximum number per material
const uint kConstantLampParts = 70u;  // some lamps are divided into parts
const uint kConstantFew = 71u;     // the first of kFewWords for each of kFewPrimitives

const uint kWorkgroupSize = 64u;  // lanes; also the 8 × 8 pixels of a film tile
const uint kTileSize = 8u;        // pixels
const uint kNone = 0xffffffffu;

const uint kBsdfDiffuse = 0u;
const uint kBsdfMirror = 1u;
const uint kBsdfDielectric = 2u;
const uint kBsdfMicrofacet = 3u;
const uint kBsdfConductor = 4u;
const uint kBsdfRoughConductor = 5u;
const uint kBsdfRoughDielectric = 6u;
const uint kBsdfThinDielectric = 7u;
const uint kBsdfPlastic = 8u;
const uint kBsdfRoughPlastic = 9u;
const uint kBsdfNull = 10u;
const uint kBsdfPrincipled = 11u;  // for its record see principled.glsl
const uint kBsdfPrincipledThin = 12u;
const uint kBsdfGltf = 13u;        // see gltf.glsl
const uint kBsdfTintedDielectric = 14u;  // a smooth dielectric with factors for reflection and transmission

// Records of adapters, which are not materials but choose one. params.x and params.y are the numbers of the candidates, params.z is a probability.
// For normal maps params.y is 1 if they follow vertex tangents.
const uint kAdapterFirst = 32u;
const uint kAdapterTwoSided = 32u;
const uint kAdapterMask = 33u;
const uint kAdapterBlend = 34u;
const uint kAdapterNormalMap = 35u;
const uint kAdapterBumpMap = 36u;  // params.z: height of white, scene units
// What params.y holds for both kinds of maps:
const uint kMapVertexTangents = 1u;  // the map follows the mesh's vertex tangents
const uint kMapUnmirrored = 2u;      // turned normals that face away stay as they are
const uint kMapUnshadowed = 4u;      // turned normals do not shadow
const uint kAdaptersLooseMaps = 0x40000000u;  // some map has one of the last two
const uint kAdaptersPass = 0x80000000u;  // in the constant with a bit for each kind of adapter: light may pass some surfaces

// A material's header: its type, kBsdf*, and what holds for it at every point.
const uint kMaterialTypeMask = 0xffu;
const uint kMaterialDelta = 0x100u;     // only delta lobes: sampling a light finds nothing
const uint kMaterialOneSided = 0x200u;  // black seen from behind
const uint kMaterialTextured = 0x400u;        // a parameter has a texture: see MaterialTextures
const uint kMaterialAligned = 0x800u;         // its frame follows the texture coordinates of the surface
const uint kMaterialBeckmann = 0x10000u;      // microfacets by Beckmann's distribution, else GGX
const uint kMaterialTransmissive = 0x20000u;  // it scatters light from both sides, and not only by delta lobes
const uint kMaterialVolume = 0x80000u;        // it encloses a medium that absorbs light
const uint kMaterialFilm = 0x100000u;         // iridescent at some of its points
const uint kMaterialDispersive = 0x200000u;   // refracts each colour differently
const uint kMaterialCoatNormal = 0x400000u;   // its coat has its own normal, see MaterialTextures
const uint kMaterialNonlinear = 0x40000u;     // light takes on the base's colour at each reflection under the coat

// Lobes as folded into the path signature.
const uint kLobeNone = 0u;
const uint kLobeDiffuse = 1u;
const uint kLobeDeltaReflection = 2u;
const uint kLobeDeltaTransmission = 3u;
const uint kLobeGlossyReflection = 4u;
const uint kLobeGlossyTransmission = 5u;
const uint kLobePassed = 6u;  // the surface was passed
const uint kLobeDiffuseTransmission = 7u;

// The environment.
const uint kEnvironmentNone = 0u;
const uint kEnvironmentGradient = 1u;
const uint kEnvironmentPicture = 2u;
const uint kEnvironmentLight = 0xfffffffeu;  // used instead of an instance if the sampled light is the environment

const uint kDeltaLightSampled = 0xfffffffdu;  // the same for a light without extent; the primitive is its number

const uint kIntegratorPath = 0u;
const uint kIntegratorNormals = 1u;
const uint kIntegratorAbsoluteNormals = 2u;
const uint kIntegratorDirect = 3u;
const uint kIntegratorWhitted = 4u;
const uint kIntegratorSimple = 5u;
const uint kIntegratorAmbientOcclusion = 6u;
const uint kIntegratorVisibility = 7u;
const uint kIntegratorDepth = 8u;
const uint kIntegratorAov = 9u;
const uint kIntegratorDistance = 10u;

// What kIntegratorAov computes: values of etendue::Aov. Those up to kAovLastAtHit are known where the camera ray arrives.
const uint kAovHit = 0u;
const uint kAovAlpha = 1u;
const uint kAovDepth = 2u;
const uint kAovPosition = 3u;
const uint kAovShadingNormal = 4u;
const uint kAovGeometricNormal = 5u;
const uint kAovUv = 6u;
const uint kAovInstance = 7u;
const uint kAovPrimitive = 8u;
const uint kAovMaterial = 9u;
const uint kAovLastAtHit = kAovMaterial;
const uint kAovNormal = 10u;
const uint kAovAlbedo = 11u;
const uint kMaxAovSegments = 64u;  // how far normal and albedo look through mirrors and glass

// Parts of the gathered light, by how often it was scattered.
const uint kLightPartAll = 0u;
const uint kLightPartDirect = 1u;    // at most once
const uint kLightPartIndirect = 2u;  // more often

// How a film position becomes a ray, see camera.glsl.
const uint kCameraPinhole = 0u;
const uint kCameraPlane = 1u;       // rays begin on a plane, each at its film position: distant and orthographic cameras
const uint kCameraLens = 2u;        // and are moved by a point of the lens
const uint kCameraSpherical = 3u;   // film positions are longitude and latitude
const uint kCameraIrradiance = 4u;  // from that plane into the hemisphere in front of it

const uint kFilterBox = 0u;
const uint kFilterTable = 1u;
const uint kFilterAlternating = 2u;  // table of a filter whose sign changes at every whole number of pixels
const uint kFilterSteps = 1024u;  // intervals of the tabulated inverse CDF

const uint kPrimitiveTriangle = 0u;
const uint kPrimitiveSphere = 1u;
const uint kPrimitiveDisk = 2u;
const uint kPrimitiveCylinder = 3u;

// The tree: nodes and primitives are interleaved in one array of 16-byte texels, so that a traversal step is one fetch, whatever it finds. A slot is
// the position of one of them. A primitive takes three texels, a Record; its a.w has kRecordNode clear because there are fewer than 2^31 instances.
// Nodes of either width store their children's boxes in 8 bits, rounded outward: along axis k, the plane q is at origin[k] + q · scale[k]. A missing
// child has an empty box. Host: src/compile/node_layout.h; kernels: node4.glsl, node8.glsl.
#ifndef ETENDUE_BVH_WIDTH
#error "ETENDUE_BVH_WIDTH, children of a node of the tree, must be defined as 4 or 8"
#endif
const uint kBvhWidth = ETENDUE_BVH_WIDTH;
const uint kRecordTexels = 3u;  // k<Struct>Texels: the size of a struct in texels of its table
const uint kSlotTexels = kBvhWidth == 8u ? 1u : 3u;  // slot s begins at texel s · kSlotTexels
const uint kPrimitiveSlots = kRecordTexels / kSlotTexels;       // slots from one primitive to the next
struct Record {
  uvec4 a, b, c;
};
const uint kRecordNode = 0x80000000u;  // in a.w

// A node of 4: a record as large as a primitive's. Child i is in slot b.w + i, with b.w even; its box spans byte i of b[k] to byte i of c[k]. origin
// = a[k] as a float, scale = 2^(byte k of a.w − 127).
const uint kNode4CountShift = 28u;  // in a.w, 3 bits: children

// A node of 8 [Ylitie2017]: four texels a, b, c, d, aligned to 64 bytes. Children are in 64-byte lines from (a.w & kNode8BaseMask) on, nodes before
// primitives: child i begins 3 i + min(i, number of nodes) texels later. b, c and d hold the planes along x, y and z: in x and y the bytes of the
// lower ones of children 0–3 and 4–7, in z and w those of the upper ones. a[k] holds the origin in its upper 27 bits, a signed multiple of
// kNode8OriginStep, and an exponent e in the lower 5: scale = 2^(e + kNode8ExponentBias − 127).
const uint kNode8CountShift = 28u;  // in a.w, 3 bits: children − 1
const uint kNode8InnerShift = 25u;  // 3 bits: children that are nodes; 7 also means 8, because min(i, 7) = min(i, 8)
const uint kNode8BaseMask = 0x1ffffffu;
const uint kNode8ExponentBits = 5u;
const uint kNode8ExponentBias = 91u;          // scales from 2^-36 to 2^-5: boxes of up to eight units
const float kNode8OriginStep = 1.0 / 33554432.0;  // 2^-25: origins in [−2, 2)

const uint kMaxTreeDepth = 64u;           // the builder's bound on wide levels

// Primitives that nearly every ray would hit in the tree (the walls of a room, the ground) are kept outside it; a scene of at most this many
// primitives has no tree. They come first in the array, in the order of the scene. Kernels receive them as specialization constants, kFewWords per
// primitive from kConstantFew on, and test them one after the other before a ray enters the tree: p0, p1 and p2 and, where light may pass something,
// the number of the instance.
const uint kFewPrimitives = 24u;
const uint kFewFloats = 9u;
const uint kFewWords = 10u;

// One analytic primitive, in normalised scene coordinates. A triangle has its three vertices; a sphere its centre in p0, its radius in p1.x, and in
// p1.y 1 if its normal points inward, otherwise 0; a disk (or its affine image) its centre in p0 and the ends of two conjugate half axes in p1 and
// p2; the side of a cylinder the ends of its axis in p0 and p1, its radius in p2.x, and in p2.y 1, or −1 if its normal points inward.
struct Primitive {
  vec3 p0;
  uint instance;   // index into instances
  vec3 p1;
  uint primitive;  // triangle index within the mesh; 0 for other shapes
  vec3 p2;
  uint kind;       // kPrimitive* in the lowest bits; above them the primitive's number in the whole scene, by instance
};
const uint kPrimitiveKindMask = 3u;
const uint kPrimitivePassable = 4u;  // light may pass the material of an instance that has it
const uint kPrimitiveOrderShift = 3u;

// Shared meshes: a record of the tree may be an instance of one. Its a.w has kRecordInstance in addition to the number of the instance, b.w is the
// slot of the root of the mesh's own tree, c.w the number of its Place; a, b and c hold the rows of object_from_world. The primitives of that tree
// are in object space, scaled to [−1, 1]; their a.w is 0, and they are numbered within the mesh.
const uint kRecordInstance = 0x40000000u;

// Where the driver traverses, there are no nodes. Records are the few primitives, those of the world, the instances (kTreeRoot is the slot of the first,
// or where it would be), and the primitives of the shared meshes, the first of which is named by b.w of an instance's record. The driver's number of an
// instance is that of its record among them; what is in the world is kQueryWorld.
const uint kQueryWorld = 0xffffffu;

// The placement of a shared mesh by an instance. A point p of the mesh's space is at origin + x p.x + y p.y + z p.z.
struct Place {
  vec3 origin;
  float error;            // bound on the rounding error, relative to the surface, of a ray that begins on the instance
  vec3 x;
  float relative_error;   // and of a ray from elsewhere, as a share of its length
  vec3 y;
  float side;             // −1 if the instance reverses the winding of the triangles, else 1
  vec3 z;
  float root_determinant; // of the matrix of x, y and z, its magnitude
  vec3 object_x;          // rows of object_from_world
  uint pad0;
  vec3 object_y;
  uint pad1;
  vec3 object_z;
  uint pad2;
};
const uint kPlaceTexels = 7u;

// Everything about a surface except its geometry.
struct Instance {
  vec3 radiance;        // 0 when it does not emit
  float light_prob;     // discrete probability of choosing this instance as a light; 0 when it does not emit
  uint material;        // index into materials
  uint first_triangle;  // into the vertex normals; kNone when there are none
  float light_area;     // total area in normalised coordinates, for a shared mesh in its own; negative if it emits on both sides
  uint place;           // for an instance of a shared mesh, index into places; kNone: its primitives and normals are in the world
};
const uint kInstanceTexels = 2u;

// Vertex normals: a texel for each triangle, because a texel for each vertex, found by an index, would cost four loads of memory that is in no cache.
// Each normal is a point of the octahedron |x| + |y| + |z| = kOctahedron, folded into the square |x|, |y| <= kOctahedron [Meyer2010]; integers of
// kOctahedronBits bits turn it by 2.1e-6 radians at most. The scale is a multiple of small numbers, so that normals along axes and diagonals are exact.
// Word k < 3: x of normal k and, above it, the low bits of y; word 3: the high bits of y, kOctahedronHighBits for each normal.
const int kOctahedron = 1048320;  // 2^8 · 3^2 · 5 · 7 · 13
const uint kOctahedronBits = 21u;
const uint kOctahedronLowBits = 11u;
const uint kOctahedronHighBits = 10u;

// A material as it is stored; the meaning of the parameters depends on its type. shaders/bsdf/bsdf.glsl turns it into a Material.
struct MaterialRecord {
  vec3 params;  // the diffuse albedo, or the transmittance of a clear boundary; dielectric: interior and exterior index; adapters: see kAdapterFirst
  uint header;  // kMaterial*
  // Only some types have the following; the others do not load it.
  vec3 specular;  // specular reflectance
  float share;    // of samples taken from the specular lobe
  vec3 eta;       // real part of a metal's complex index; else the interior and the exterior index; for a rough coat, whether its roughness varies
  float alpha_u;
  vec3 k;         // for a metal; under a coat: share reflected back inside, (ext/int)², first texel of its table
  float alpha_v;
  // Additional data of glTF's material; see gltf.glsl.
  vec4 sheen;
  vec4 scattered;
  vec4 film;
  vec4 volume;
};
const uint kMaterialTexels = 8u;
const uint kRichMaterialTexels = 4u;  // for all others
// The transmittance of a rough coat for light entering it, at cosines evenly spaced over [0, 1]: a table after the materials, four nodes per texel.
const uint kTransmittanceNodes = 64u;
// A coat with textured roughness has a table for each of these roughnesses, whose roots are evenly spaced over [0, 1], and after each a texel with
// the share that it reflects back inside.
const uint kCoatRoughnesses = 16u;
const uint kCoatTexels = kTransmittanceNodes / 4u + 1u;
// The albedo of white sheen, at cosines evenly spaced over [0, 1], for roughnesses evenly spaced over [0.1, 1].
const uint kSheenCosines = 32u;
const uint kSheenRoughnesses = 16u;

// The textures of a material with kMaterialTextured: a table of its own with the indices of the materials, empty where none has any.
struct MaterialTextures {
  uint first;  // kTextureOf… of the first parameter: the albedo, or an adapter's number; kNone if it has none
  uint begin;  // first of the material's texture uses
  uint end;
  uint coat_normals;  // kTextureOf… and kTextureOfVertexTangents of a coat's normal map, or kNone
};
const uint kMaterialTexturesTexels = 1u;
// A texture that multiplies floats of a MaterialRecord.
struct TextureUse {
  uint texture_of;  // kTextureOf…
  uint floats;      // bit i: the i-th float of the record. Colours are at the beginning of a texel. kFloatsTurn: none
  float least;      // the range that the product is clamped to
  float most;
};
const uint kTextureUseTexels = 1u;
const uint kFloatsTurn = 0x10000000u;  // red and green are a direction, which rotates the tangent of a glTF material
// The texture that multiplies a parameter: its index, and above it the channel to use as a number, as in etendue::TextureChannel, or that it is a
// colour.
const uint kTextureOfIndexMask = 0xffffffu;
const uint kTextureOfChannelShift = 24u;
const uint kTextureOfColor = 0xfu;
const uint kTextureOfVertexTangents = 0x80000000u;

// A texture, see texture.glsl.
struct TextureRecord {
  uint header;  // kTexture*
  uint first;   // for a picture, the position of its first texel, in multiples of 16 bytes; for a checkerboard, the texture of its even squares or kNone
  uint width;   // for a checkerboard, the texture of its odd squares
  uint height;
  vec3 u_row;   // texture coordinates of the surface (u, v, 1) → those of the texture
  uint uv_set;
  vec3 v_row;
  float cutoff;  // of alpha, with kTextureCut
  vec3 color0;  // of a checkerboard
  uint pad1;
  vec3 color1;
  uint pad2;
};
const uint kTextureRecordTexels = 5u;
const uint kTextureKindMask = 3u;
const uint kTextureBitmap = 0u;
const uint kTextureCheckerboard = 1u;
const uint kTextureVertexColor = 2u;
const uint kTextureFaceColor = 3u;
const uint kTextureWrapUShift = 2u;  // 2 bits each, as in etendue::TextureWrap
const uint kTextureWrapVShift = 4u;
const uint kTextureWrapMask = 3u;
const uint kTextureWrapRepeat = 0u;
const uint kTextureWrapMirror = 1u;
const uint kTextureBilinear = 0x40u;
const uint kTextureSrgb = 0x80u;       // colours are sRGB-encoded
const uint kTextureFormatShift = 8u;   // 2 bits, log2 of the bytes of a number: 8 bits, half and single floats
const uint kTextureFormatMask = 3u;
const uint kTextureChannelsShift = 10u;  // 3 bits
const uint kTextureChannelsMask = 7u;
const uint kTextureTinted = 0x2000u;         // multiplied with the mesh's vertex colours
const uint kTextureCut = 0x4000u;            // alpha becomes 1 from the cutoff on, else 0
const uint kTexturePremultiplied = 0x8000u;  // colours are multiplied with alpha, after that
// Features used by the textures of a scene: kernels are built for exactly these; a scene without textures pays nothing.
const uint kTexturesBitmap = 0x1u;
const uint kTexturesCheckerboard = 0x2u;
const uint kTexturesAttribute = 0x4u;
const uint kTexturesBilinear = 0x8u;
const uint kTexturesSrgb = 0x10u;
const uint kTexturesThreeChannels = 0x20u;  // a texel may span two loads
const uint kTexturesRadiance = 0x40u;       // an emitter has one
const uint kTexturesSphere = 0x80u;         // a sphere has one
const uint kTexturesRich = 0x100u;          // a material has one that is not a diffuse albedo: see TextureUse
const uint kTexturesDisk = 0x200u;          // a disk has one
const uint kTexturesCylinder = 0x400u;      // a cylinder has one
const uint kTexturesTangents = 0x800u;      // a material has kMaterialAligned
const uint kTexturesCoat = 0x2000u;         // the roughness of a rough coat is one
const uint kTexturesAlpha = 0x4000u;        // one has kTextureCut or kTexturePremultiplied
const uint kTexturesVertexTangents = 0x8000u;  // a normal map follows the mesh's vertex tangents
const uint kTexturesTurn = 0x40000u;        // a material has kFloatsTurn
const uint kTexturesNested = 0x20000u;      // a checkerboard contains textures
const uint kTexturesTinted = 0x10000u;      // one has kTextureTinted
const uint kTexturesMesh = 0x1000u;         // texture coordinates of meshes are needed, with or without textures

// What the textures of an instance need from its shape; empty if the scene has no textures. Each primitive has a block of texels: for each set of
// texture coordinates, (u, v) of the three corners in two texels; then the colours of the corners with their alpha; then that of the face; then the
// tangents of the corners (xyz, in the world, for shared meshes in their own space; w: the side of the bitangent). A sphere has the rows of the
// rotation from the world into its own space.
struct InstanceAttributes {
  uint first;             // texel of the attributes
  uint layout_bits;       // kAttributes*
  uint radiance_texture;  // index of the texture that its radiance is multiplied with, or kNone
  uint pad0;
};
const uint kInstanceAttributesTexels = 1u;
const uint kAttributesSetsMask = 0xffu;  // sets of texture coordinates
const uint kAttributesVertexColors = 0x100u;
const uint kAttributesFaceColors = 0x200u;
const uint kAttributesSphere = 0x400u;
const uint kAttributesDisk = 0x800u;
const uint kAttributesTurned = 0x1000u;  // for a disk: its half axes are stored in reverse order
const uint kAttributesCylinder = 0x2000u;
const uint kAttributesTangents = 0x4000u;

// An instance that emits: chosen when `threshold <= word`, the last one that satisfies it.
struct LightInstance {
  uint threshold;
  uint instance;
  uint first_primitive;  // into the light primitives
  uint primitive_count;
};
const uint kLightInstanceTexels = 1u;

// An emitting primitive with its geometry: lights do not depend on the tree. Those of a shared mesh are in its own space. Or, of a lamp that is
// divided into parts, one of them, see etendue::LampParts.
struct LightPrimitive {
  Primitive primitive;
  uint threshold;
  float prob;  // probability within its instance
  uint cells;  // of the triangle along a side; 0: the lamp is not divided
  uint cell;
};
const uint kLightPrimitiveTexels = 4u;

// An upper bound for a group of lights.
struct LightBounds {
  vec3 center;     // of its box
  float radius;    // of the sphere around that box
  vec3 axis;       // of the cone of normals
  float cos_cone;  // of the cone's half angle
};
const uint kLightBoundsTexels = 2u;
// A branching of the light tree; the first pair is the root's. Both halves are stored together, because the choice between them needs both.
struct LightPair {
  LightBounds left_bounds, right_bounds;
  float left_power;  // shares of all lights
  float right_power;
  uint left;         // a pair, or kLightLeaf | index of a light primitive
  uint right;
};
const uint kLightPairTexels = 5u;
const uint kLightLeaf = 0x80000000u;
const uint kLightLeafShared = 0x40000000u;  // in addition to it: the index is that of a light instance with a shared mesh
const uint kLightLeafDelta = 0x20000000u;   // with kLightLeaf, or in the instance of a light: the index is that of a light without extent
const uint kMaxLightTreeDepth = 31u;

// The path from the root of the light tree to a primitive, or to a part of it. Without a tree there are trails only of lamps that are divided into
// parts.
struct LightTrail {
  uint turns;  // bit i is 1 if level i turns right, followed by a final 1; 0 if the primitive is not a light
  float area;  // of the primitive or part; without a tree, divided by the probability of the part within its instance
  uint cells;  // of the triangle along a side; 0: this is the primitive's own trail
  uint first;  // of the trails of its parts
};
const uint kLightTrailTexels = 1u;

// A light without extent, in normalised coordinates. Those infinitely far away come first in the table.
struct DeltaLight {
  vec3 p;             // position; for a directional light the direction toward it
  float prob;         // probability of its choice, if lights are chosen by power
  vec3 intensity;     // irradiance at distance 1 of a surface that faces it
  uint header;        // kDelta…
  vec3 forward;       // direction of emission, unit
  float cos_cutoff;   // of a spot's cone
  vec3 across;        // axis of its picture's columns, unit
  float cos_beam;
  vec2 picture_scale; // half the picture at a slope of 1, horizontally and vertically
  float fade;         // 1 divided by the difference between beam and cone: in turns if linear, else in cosines
  uint texture_index; // of its picture, or kNone
  uint threshold;     // of a directional light: chosen when `threshold <= word`, the last one that satisfies it
  uint number;        // among those of the scene
  float cutoff_turns; // half angle of the cone
  uint pad0;
};
const uint kDeltaLightTexels = 6u;
const uint kDeltaPoint = 0x1u;
const uint kDeltaSpot = 0x2u;
const uint kDeltaProjector = 0x4u;
const uint kDeltaDirectional = 0x8u;
const uint kDeltaSmooth = 0x10u;   // how a spot fades; linearly without either
const uint kDeltaQuartic = 0x20u;
const uint kDeltaTextured = 0x40u; // has a picture

// A row of cells of the environment. Its edges are sin²(θ/2), with θ the angle from the pole of its half of the rows, so that no precision is lost
// near the poles.
struct EnvironmentRow {
  float density;   // w.r.t. solid angle if all of its cells had equal probability; includes the choice of the row
  float upper_edge;
  float lower_edge;
  uint column_count;  // later cells have no weight
};
const uint kEnvironmentRowTexels = 1u;

// A texel of the environment's picture, and the number of words, out of 2^32, that choose the cell of the same row and column within the row; 0 if all
// do.
struct EnvironmentTexel {
  vec3 radiance;
  uint words;
};
const uint kEnvironmentTexelTexels = 1u;

// A choice of one of `count` entries by thresholds, as a tree whose nodes have kSearchFan branches: a node is the uvec4
// of the thresholds at which its second to last branches begin. The nodes of a level are consecutive, the root's level
// comes first; beyond the last entry, thresholds have the largest value.
const uint kSearchFan = 5u;

// Everything that is constant during a render. Directions and positions are in normalised scene coordinates.
struct Frame {
  vec3 camera_origin;
  float near_clip;
  vec3 camera_x;     // world direction of camera +X, not normalised (toWorld may scale)
  float far_clip;
  vec3 camera_y;
  float tan_x;       // half the film's width at unit distance
  vec3 camera_z;
  float tan_y;
  vec3 sky_top;
  float filter_weight;  // ∫|f|/∫f of the reconstruction filter, per axis
  vec3 sky_horizon;
  float distance_scale;   // normalised length of one scene unit
  uint width;
  uint height;
  uint tiles_x;           // film tiles per row
  uint seed;
  uint max_depth;
  uint rr_depth;          // kNone: no roulette
  int film_exponent;
  uint light_instance_count;
  float filter_zero;      // |x| in pixels beyond which the filter is negative; infinite when it never is
  // Half the width and height, in camera units, of the plane on which rays begin; 0 if they begin at camera_origin. The clipping distances are depths
  // beyond that plane.
  float plane_x;
  float plane_y;
  float plane_depth;      // of that plane; camera units, like the clipping distances
  // A point of the lens, in units of its radius, moves a ray's start by lens_offset and its direction at depth 1 by lens_slope.
  float lens_offset;
  float lens_slope;
  float lens_rotation;    // of the aperture's first corner from camera +X toward +Y, in turns
  uint lens_blades;       // corners of the aperture; 0: a disk
  vec2 window_offset;     // with kConstantCameraWindow: film position p is at window_offset − window_scale · p
  vec2 window_scale;
  // Parameters of some integrators.
  vec3 light_position;
  float ray_length;       // of an occlusion ray, possibly infinite; for distance the share of a camera ray's way to its start that counts
  vec3 light_intensity;   // Φ/(4π²) at a distance of one scene unit, in normalised units
  uint emitter_samples;
  uint bsdf_samples;
  uint distant_threshold;      // words below it that do not choose the environment choose a directional light
  float delta_light_limit;     // maximum contribution of a light without extent at a vertex
  uint aov;                    // kAov…
  vec3 sky_x;                  // axes of the sky's own frame in the world
  uint environment_row_count;  // rows of cells; later ones have no weight
  vec3 sky_y;
  uint environment_threshold;  // words below it choose the environment, others a light
  vec3 sky_z;
  float lights_prob;           // of the latter
  vec3 scene_center;           // in the world; normalised coordinates are relative to it, times distance_scale
  uint pad0;
};

// The work of one dispatch: some paths for each of a run of film slots, shared among its lanes, see integrator/render_lane.glsl.
struct Pass {
  uint first_group;      // of slots, counted over the whole film
  uint first_slot;       // the same within the bound film band
  uint group_count;      // of slots
  uint paths;            // given to each slot, fewer where its sets end
  uint paths_before;     // given to each slot before
  uint first_set;        // first set to render; a set is one path, but see sampler.glsl
  uint sets;             // number of sets up to the end of this pass
  uint slots_per_pixel;  // a pixel's sets are distributed round-robin over this many slots
  uint packed_pixels;    // not 0: slots are packed, pixel = slot % packed_pixels; 0: slots are tiles
  uint step_budget;      // traversal steps that a lane may take before it returns its path
  uint resume;           // 1: lanes continue where the last dispatch of this pass stopped
  uint request_count;    // for kernels with requests: their number
};

// One film slot: the 128 bytes of etendue::FilmPixel.
struct FilmSlot {
  uvec4 sum_r, sum_g, sum_b;
  uvec4 squares_a, squares_b, squares_c, squares_d;  // 3 channels × 6 limbs, then two words of the last quad are below
  uvec4 tail;                                        // squares limbs 16, 17, count, rejected
};

const uint kRejectedListed = 64u;
struct RejectedEntry {
  uint pixel;
  uint sample_index;
  uint segments;
  uint pad0;
};
struct ReportHead {
  uint unfinished;      // lanes that used up their step budget
  uint stuck;           // samples that alone exceed the budget
  uint rejected_count;  // samples rejected since the report was cleared
  uint pad0;
};

// trace_samples: one request, one record.
struct SampleRequest {
  uint pixel;
  uint sample_index;
  uint pad0;
  uint pad1;
};
struct SampleResult {
  vec3 radiance;
  uint signature;
  uint segments;
  uint stuck;  // 1 when the path exceeded the step budget
  uint pad0;
  uint pad1;
};
// trace_rays: rays with a direction of unit length, in normalised coordinates.
struct RayRequest {
  vec3 o;
  float t_min;
  vec3 d;
  float t_max;
};
struct RayResult {
  float t;
  uint instance;   // kNone: no hit
  uint primitive;
  uint steps;
};
// What a path did, counted by the profiling build of the render kernel. For each class of rays: rays, nodes, primitives.
struct PathProfile {
  uvec4 camera, scattered, shadow;
  vec4 shares;  // x: this lane's share of its subgroup's traversal steps, y: its own steps; z, w: the same for shading
};
// bsdf_samples: push constants and results of one material's probe. Queries are directions, one vec4 each, with the number of a sample in w.
const uint kProbeSamples = 0u;  // samples
const uint kProbeMixed = 1u;    // eval and pdf at the queries, with the choices of those samples
const uint kProbeChosen = 2u;   // the same of the chosen material alone, without what it is mixed with
struct BsdfProbePass {
  vec3 wo;
  uint seed;
  uint first;  // number of the first sample
  uint count;
  uint mode;   // kProbe…
  uint pad0;
};
struct BsdfProbeResult {
  vec3 wi;      // the query when evaluating
  float pdf;
  vec3 weight;  // eval when evaluating
  uint lobe;
};
const uint kMaxTracedVertices = 256u;
struct TracedVertex {
  vec3 radiance;
  uint instance;
  uint primitive;
  uint light_instance;
  uint light_primitive;
  uint light_contributed;
  uint lobe;
  uint survived;
  uint pad0;
  uint pad1;
  vec3 from;  // where the segment begins
  uint pad2;
  vec3 to;    // where it ends; its direction if it hits nothing
  uint pad3;
};

#ifdef __cplusplus
constexpr uint kTexelBytes = sizeof(uvec4);
static_assert(sizeof(Record) == kRecordTexels * kTexelBytes);
static_assert(sizeof(Primitive) == kRecordTexels * kTexelBytes);
static_assert(sizeof(Place) == kPlaceTexels * kTexelBytes);
static_assert(sizeof(Instance) == kInstanceTexels * kTexelBytes);
static_assert(sizeof(MaterialRecord) == kMaterialTexels * kTexelBytes);
static_assert(sizeof(MaterialTextures) == kMaterialTexturesTexels * kTexelBytes);
static_assert(sizeof(TextureUse) == kTextureUseTexels * kTexelBytes);
static_assert(sizeof(TextureRecord) == kTextureRecordTexels * kTexelBytes);
static_assert(sizeof(InstanceAttributes) == kInstanceAttributesTexels * kTexelBytes);
static_assert(sizeof(LightInstance) == kLightInstanceTexels * kTexelBytes);
static_assert(sizeof(LightPrimitive) == kLightPrimitiveTexels * kTexelBytes);
static_assert(sizeof(LightBounds) == kLightBoundsTexels * kTexelBytes);
static_assert(sizeof(LightPair) == kLightPairTexels * kTexelBytes);
static_assert(sizeof(LightTrail) == kLightTrailTexels * kTexelBytes);
static_assert(sizeof(DeltaLight) == kDeltaLightTexels * kTexelBytes);
static_assert(sizeof(EnvironmentRow) == kEnvironmentRowTexels * kTexelBytes);
static_assert(sizeof(EnvironmentTexel) == kEnvironmentTexelTexels * kTexelBytes);
static_assert(sizeof(Frame) == 288);
static_assert(sizeof(Pass) == 48);
static_assert(sizeof(FilmSlot) == 128);
static_assert(sizeof(SampleResult) == 32);
static_assert(sizeof(PathProfile) == 64);
static_assert(sizeof(BsdfProbePass) == 32);
static_assert(sizeof(BsdfProbeResult) == 32);
static_assert(sizeof(TracedVertex) == 80);
}  // namespace etendue::gpu
#endif
#endif
