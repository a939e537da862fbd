// What the materials of a scene have in common.
#ifndef MATERIAL_FLAGS_GLSL
#define MATERIAL_FLAGS_GLSL

#include "gpu_types.h"

// The flags that some material of the scene has, and those that all have: where the two agree, nobody asks the material.
layout(constant_id = kConstantMaterialFlagsSome) const uint kMaterialFlagsSome = 0xffffffffu;
layout(constant_id = kConstantMaterialFlagsAll) const uint kMaterialFlagsAll = 0u;

#endif
