#pragma once
/// Whether the numbers that renderers compute with can tell a picture's pixels apart.

#include <string>

#include "scene/scene.h"

namespace etendue {

/// One sentence about a camera whose pixels are smaller than what single precision (or even double precision) can
/// resolve, with the numbers and the remedy; empty where the picture can be trusted. A picture of one pixel has nothing
/// to resolve.
std::string precision_complaint(const Scene& scene);

}  // namespace etendue
