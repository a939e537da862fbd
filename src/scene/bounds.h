#pragma once
/// Boxes around the contents of a scene.

#include <limits>
#include <vector>

#include "scene/scene.h"
#include "scene/sharing.h"

namespace etendue {

/// Axis-aligned box in world space; empty when new.
struct Bounds {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  void add(const glm::dvec3& p) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  bool empty() const { return !(min.x <= max.x); }
};

/// In object space.
Bounds bounds_of(const Shape& shape);
/// The box around the transformed box, corners included.
Bounds transformed(const Bounds& box, const glm::dmat4& world_from_object);

Bounds bounds_of(const Scene& scene, const Instance& instance);
/// The box of all instances; empty if there are none. Instances of shared meshes count by their transformed boxes.
Bounds bounds_of(const Scene& scene);
/// How far the bulk of a scene extends: the lower median, over all instances, of the larger of two numbers, half the
/// diagonal of its box and the distance of the box's centre from the median centre (per coordinate). A large floor
/// counts no more than anything else. 0 if there are no instances.
double typical_radius(const Scene& scene);

/// Box of each instance: as exact as `bounds_of(scene, instance)`, or around the transformed box of the mesh if that is
/// shared, which costs nothing for any number of instances.
std::vector<Bounds> instance_bounds(const Scene& scene, const Sharing& sharing);

}  // namespace etendue
