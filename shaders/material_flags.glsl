// What the materials of a scene have in common.
#ifndef MATERIAL_FLAGS_GLSL
#define MATERIAL_FLAGS_GLSL

#include "features.glsl"
#include "gpu_types.h"

// The flags that some material of the scene has, and those that all have; where the two agree, the material need not be
// read.
layout(constant_id = kConstantMaterialFlagsSome) const uint kMaterialFlagsSome = 0xffffffffu;
layout(constant_id = kConstantMaterialFlagsAll) const uint kMaterialFlagsAll = 0u;

// The kinds of adapters in the scene: bit i for the type kAdapterFirst + i, and kAdaptersPass if there are surfaces
// that light may pass. Without any, a surface's material is that of its instance.
FEATURE(uint, kAdapters, kConstantAdapters, 0u)
const bool kPassable = (kAdapters & kAdaptersPass) != 0u;
const bool kPerturbed = (kAdapters >> (kAdapterNormalMap - kAdapterFirst) & 3u) != 0u;  // maps turn shading normals
const bool kLooseMaps = (kAdapters & kAdaptersLooseMaps) != 0u;  // some of them with unusual settings
const bool kBlended = (kAdapters >> (kAdapterBlend - kAdapterFirst) & 1u) != 0u;

#endif
