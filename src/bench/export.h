#pragma once
/// Scenes and rays for other programs (tests/bench/compare), in formats that take no library to read.

#include <string>
#include <vector>

#include "bench/ray_sets.h"

namespace etendue {

/// Writes scene.json and one PLY file (binary, little-endian, triangles in world space) for each instance of a mesh
/// into `folder`, which is made. A mirrored camera becomes an ordinary one of a scene mirrored at x = 0, because few
/// programs take the former: the picture is the same. Throws Error(scene) for a camera that shears or scales its
/// axes differently, Error(file).
void export_scene(const Scene& scene, const std::string& folder);

/// Writes the primitives of the scene in normalised coordinates, the ray sets and their answers to one file,
/// little-endian:
///   char[8] "ETDRAYS1", uint64 triangles, uint64 spheres, uint64 sets,
///   triangles × float[9] vertices, spheres × float[4] centre and radius,
///   and for each set: char[16] class, uint32 shuffled, uint32 any hit, uint64 rays,
///   rays × float[8] (o, t_min, d, t_max), rays × float distance (infinite: no hit; any hit: 0).
void export_rays(const Scene& scene, const Placement& placement, const std::vector<RaySet>& sets,
                 const std::vector<std::vector<CastHit>>& hits, const std::string& path);

}  // namespace etendue
