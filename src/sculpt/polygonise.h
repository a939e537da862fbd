#pragma once
/// Turns a solid into a triangle mesh.

#include "sculpt/field.h"
#include "sculpt/mesh.h"

namespace etendue::sculpt {

/// A closed mesh with smooth normals and at least `triangles` triangles, usually a few per cent more. The result is the
/// same on every machine and for any number of threads.
Mesh polygonise(const Solid& solid, std::uint64_t triangles);

}  // namespace etendue::sculpt
