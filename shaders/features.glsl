// Features that most scenes do without. Kernels for those scenes are built once more, with ETENDUE_PLAIN, and do not hold them: the driver
// reads and optimizes everything in a kernel before it sees what constants rule out, and half of the time to the first sample was that.
// gpu/kernel_set.cpp knows what a plain kernel does not have.
#ifndef FEATURES_GLSL
#define FEATURES_GLSL

#include "gpu_types.h"

#ifdef ETENDUE_PLAIN
#define FEATURE(type, name, id, off) const type name = off;
const uint kBsdfsBuilt = 1u << kBsdfDiffuse | 1u << kBsdfMirror | 1u << kBsdfDielectric;
#else
#define FEATURE(type, name, id, off) layout(constant_id = id) const type name = off;
const uint kBsdfsBuilt = 0xffffffffu;
#endif

#endif
