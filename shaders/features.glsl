// Features that most scenes do not need. Kernels for those scenes are built a second time, with ETENDUE_PLAIN, without these features: the driver
// reads and optimizes everything in a kernel before it sees what constants rule out, which was half of the time to the first sample.
// gpu/kernel_set.cpp decides which scenes can use a plain kernel.
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
