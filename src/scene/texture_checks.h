#pragma once
/// Invariants of textures and of the objects that use them; part of check_invariants.

#include "scene/invariants.h"

namespace etendue {

/// True where indices and tables are sound, so that textures can be evaluated. Instances must refer to shapes,
/// materials and emitters that are there.
bool check_textures(const Scene& scene, Diagnostics& diagnostics, const LocateField& locate);

}  // namespace etendue
