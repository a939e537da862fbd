#pragma once
/// The position and direction of a camera, as numbers that a user can control.

#include <string>

#include "scene/bounds.h"
#include "scene/scene.h"

namespace etendue::view {

/// In world space. `up` has unit length and need not be perpendicular to the direction of view.
struct Pose {
  glm::dvec3 eye{0.0}, target{0.0, 0.0, 1.0}, up{0.0, 1.0, 0.0};
  bool operator==(const Pose&) const = default;
};

/// The pose of `camera`. `target` lies in front of it, at the distance of the middle of `bounds`; `up` is the world
/// axis that appears upright in the picture, or the camera's own if there is none.
Pose pose_of(const Camera& camera, const Bounds& bounds);

/// Why a camera cannot have this pose; "" if it can.
std::string pose_complaint(const Pose& pose);

/// The camera moved to another pose; `before` is the pose of `camera`. Scales and reflections of its transform are
/// kept.
Camera moved(const Camera& camera, const Pose& before, const Pose& after);

}  // namespace etendue::view
