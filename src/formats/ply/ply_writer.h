#pragma once
/// Meshes as PLY files, with everything that they have and every digit of it.

#include <string>

#include "scene/scene.h"

namespace etendue {

/// Binary, little-endian; v of texture coordinates as it is. Throws Error(scene) for a mesh with several sets of
/// texture coordinates, of which PLY files have one; Error(file).
void write_ply(const std::string& path, const TriangleMesh& mesh);

}  // namespace etendue
