#pragma once
/// Surfaces that lie in one another: which of them is seen is then a matter of convention.

#include "scene/diagnostics.h"
#include "scene/scene_file.h"

namespace etendue {

/// Warns, once for each pair of instances, where triangles of both overlap in one plane and it matters: they face the
/// same way, or one of them is glass; and where two spheres are the same. A block that stands on a floor is not
/// reported: nobody sees the two faces. Bounded work: at most some millions of pairs of triangles are looked at, in the
/// order of the scene. Instances of shared meshes are left out.
void check_coincident(const Scene& scene, Diagnostics& diagnostics);
/// The same for every scene of a file. The command `check` asks; a render does not wait for it.
void check_coincident(const SceneFile& file, Diagnostics& diagnostics);

}  // namespace etendue
