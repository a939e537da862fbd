#include "view/pose.h"

#include <algorithm>
#include <cmath>

namespace etendue::view {
namespace {

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// The rigid frame of a pose: X to the side, Y up, Z forward.
glm::dmat4 frame_of(const Pose& pose) {
  const glm::dvec3 z = glm::normalize(pose.target - pose.eye);
  const glm::dvec3 x = glm::normalize(glm::cross(pose.up, z));
  return {glm::dvec4(x, 0.0), glm::dvec4(glm::cross(z, x), 0.0), glm::dvec4(z, 0.0), glm::dvec4(pose.eye, 1.0)};
}

/// The world axis that is perpendicular to `across` and nearest to `up`; `up` itself if there is none.
glm::dvec3 upright(const glm::dvec3& across, const glm::dvec3& up) {
  constexpr double kLevel = 1e-3;
  glm::dvec3 best = up;
  double most = 0.2;  // below this, an axis is closer to the horizon than to upright
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 candidate(0.0);
    candidate[axis] = up[axis] < 0.0 ? -1.0 : 1.0;
    const double along = glm::dot(candidate, up);
    if (std::abs(across[axis]) < kLevel && along > most) {
      most = along;
      best = candidate;
    }
  }
  return best;
}

}  // namespace

Pose pose_of(const Camera& camera, const Bounds& bounds) {
  const glm::dmat4& m = camera.world_from_camera;
  const glm::dvec3 ahead = glm::normalize(glm::dvec3(m[2]));
  Pose pose{.eye = glm::dvec3(m[3]), .target{}, .up = glm::normalize(glm::dvec3(m[1]))};
  double distance = 1.0;
  if (!bounds.empty()) {
    const double size = glm::length(bounds.max - bounds.min);
    const double middle = glm::dot(0.5 * (bounds.min + bounds.max) - pose.eye, ahead);
    distance = std::max(middle, size > 0.0 ? 0.05 * size : 1.0);
  }
  pose.target = pose.eye + distance * ahead;
  const glm::dvec3 across = glm::normalize(glm::dvec3(m[0]));
  pose.up = upright(across, pose.up);
  return pose;
}

std::string pose_complaint(const Pose& pose) {
  constexpr double kFarthest = 1e15;
  if (!is_finite(pose.eye) || !is_finite(pose.target) || !is_finite(pose.up)) return "a number is not finite";
  for (int i = 0; i < 3; ++i) {
    if (std::abs(pose.eye[i]) > kFarthest || std::abs(pose.target[i]) > kFarthest)
      return "the camera is farther away than 1e15";
  }
  const glm::dvec3 ahead = pose.target - pose.eye;
  const double distance = glm::length(ahead), height = glm::length(pose.up);
  if (!(distance > 0.0) || !std::isfinite(distance)) return "the camera looks at its own position";
  if (!(height > 0.0)) return "up is the zero vector";
  if (!(glm::length(glm::cross(ahead / distance, pose.up / height)) > 1e-6))
    return "the camera looks straight up or down";
  return "";
}

Camera moved(const Camera& camera, const Pose& before, const Pose& after) {
  if (after == before) return camera;  // to the last bit
  Camera out = camera;
  out.world_from_camera = frame_of(after) * (glm::inverse(frame_of(before)) * camera.world_from_camera);
  out.world_from_camera[3] = glm::dvec4(after.eye, 1.0);
  return out;
}

}  // namespace etendue::view
