#pragma once
/// Boxes of primitives in the form in which they are uploaded.

#include "compile/box.h"
#include "gpu_types.h"

namespace etendue {

/// Contains the whole primitive; for curved ones, rounded outward.
Box primitive_box(const gpu::Primitive& p);

}  // namespace etendue
