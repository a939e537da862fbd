#include "compile/primitive_box.h"

#include <cmath>

#include "scene/placed.h"

namespace etendue {
namespace {

// The box of all points within `reach` of a point along each axis, rounded outward.
Box box_around(const glm::dvec3& point, const glm::dvec3& reach) {
  Box box;
  for (int a = 0; a < 3; ++a) {
    box.lower[a] = std::nextafter(static_cast<float>(point[a] - reach[a]), -INFINITY);
    box.upper[a] = std::nextafter(static_cast<float>(point[a] + reach[a]), INFINITY);
  }
  return box;
}

}  // namespace

Box primitive_box(const gpu::Primitive& p) {
  Box box;
  const glm::dvec3 p0(p.p0), p1(p.p1), p2(p.p2);
  const gpu::uint kind = p.kind & gpu::kPrimitiveKindMask;
  if (kind == gpu::kPrimitiveSphere) {
    for (int a = 0; a < 3; ++a) {  // rounded outward
      box.lower[a] = std::nextafter(p.p0[a] - p.p1.x, -INFINITY);
      box.upper[a] = std::nextafter(p.p0[a] + p.p1.x, INFINITY);
    }
  } else if (kind == gpu::kPrimitiveDisk) {
    box = box_around(p0, PlacedDisk{p0, p1 - p0, p2 - p0}.reach());
  } else if (kind == gpu::kPrimitiveCylinder) {
    const glm::dvec3 reach = PlacedCylinder{p0, p1, p2.x, false}.reach();
    box = box_around(p0, reach);
    box.extend(box_around(p1, reach));
  } else {
    box.extend(p.p0);
    box.extend(p.p1);
    box.extend(p.p2);
  }
  return box;
}

}  // namespace etendue
