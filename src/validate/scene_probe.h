#pragma once
/// What some thousand paths tell about a scene that no look at its parts does: a camera that sees nothing, light that
/// never arrives.

#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// Scenes with more primitives are not probed: reading them takes long enough.
inline constexpr std::size_t kMaxProbedPrimitives = std::size_t{1} << 21;

/// Follows one path through each pixel of a small film, on the reference, and warns when no camera ray meets anything,
/// when no path finds light, or when an emitter that was tried often was never reached. Chance could at worst hide what
/// is as small as a pixel of 64 × 64, so the sentences give the number of paths. Takes a second at most, but for
/// building the tree.
void probe_scene(Scene scene, Diagnostics& diagnostics);

}  // namespace etendue
