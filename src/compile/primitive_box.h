#pragma once
/// Boxes of primitives as they are uploaded.

#include "compile/box.h"
#include "gpu_types.h"

namespace etendue {

/// Holds all of the primitive; of what is not flat, rounded outward.
Box primitive_box(const gpu::Primitive& p);

}  // namespace etendue
