#pragma once
/// Checks for what is legal in a scene but probably not intended.

#include "scene/diagnostics.h"
#include "scene/scene_file.h"

namespace etendue {

/// Adds warnings about a scene that was read without errors: no light, emitters that face away from everything, a
/// camera inside glass, vertex normals against the winding, glass that is not closed, shapes too small for single
/// precision, parameters without effect, pixels too small to be resolved. Linear in the number of triangles, except for
/// sorting the edges of dielectric meshes.
void check_scene(const Scene& scene, Diagnostics& diagnostics);
/// The same for every scene of a file.
void check_scene_file(const SceneFile& file, Diagnostics& diagnostics);

}  // namespace etendue
