#pragma once
/// Shapes of scene files that are meshes of a few triangles.

#include "scene/scene.h"

namespace etendue {

/// The square [−1, 1]² in the plane z = 0, its normal +z; (u, v) runs from 0 at (−1, −1) to 1 at (1, 1). Flat, as its
/// winding says: a mesh needs no vertex normals for that.
TriangleMesh make_rectangle();

/// Corners origin, origin + u, origin + u + v and origin + v, seen from the side to which u × v points; texture
/// coordinates from 0 to 1 along u and v.
TriangleMesh make_parallelogram(const glm::dvec3& origin, const glm::dvec3& u, const glm::dvec3& v);

/// The cube [−1, 1]³ with its normals outward. Each face has the whole of [0, 1]², in the manner of Mitsuba: seen from
/// outside, with u to the right, v runs downward.
TriangleMesh make_cube();

}  // namespace etendue
