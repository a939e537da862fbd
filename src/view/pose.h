#pragma once
/// Where a camera stands, in numbers that can be steered.

#include <string>

#include "scene/bounds.h"
#include "scene/scene.h"

namespace etendue::view {

/// In world space. `up` has unit length and need not be perpendicular to the direction of view.
struct Pose {
  glm::dvec3 eye{0.0}, target{0.0, 0.0, 1.0}, up{0.0, 1.0, 0.0};
  bool operator==(const Pose&) const = default;
};

/// The camera's own. `target` lies before it, as far as the middle of `bounds` does; `up` is the axis of the world that
/// the camera stands upright by, or its own where there is none.
Pose pose_of(const Camera& camera, const Bounds& bounds);

/// Why a camera cannot stand like this; "" where it can.
std::string pose_complaint(const Pose& pose);

/// A camera at another pose. Whatever its transform does beside placing it (scales, mirrors) stays as it is; `before`
/// is the pose of `camera`.
Camera moved(const Camera& camera, const Pose& before, const Pose& after);

}  // namespace etendue::view
