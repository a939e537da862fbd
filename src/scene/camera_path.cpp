#include "scene/camera_path.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

#include "image/vectors.h"

namespace etendue {
namespace {

/// Cosine between axes that count as at right angles.
constexpr double kRightAngle = 1e-6;

/// T R S; of mirrored axes x has a negative length.
struct Parts {
  glm::dvec3 place{0.0};
  glm::dquat turn{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 lengths{1.0};
};

bool is_mirrored(const glm::dmat4& m) {
  return glm::determinant(glm::dmat3(m)) < 0.0;
}

Parts parts_of(const glm::dmat4& m) {
  glm::dmat3 axes(m);
  Parts parts{.place = glm::dvec3(m[3])};
  for (int i = 0; i < 3; ++i) {
    parts.lengths[i] = glm::length(axes[i]);
    axes[i] /= parts.lengths[i];
  }
  if (is_mirrored(m)) {
    axes[0] = -axes[0];
    parts.lengths.x = -parts.lengths.x;
  }
  parts.turn = glm::normalize(glm::quat_cast(axes));
  return parts;
}

glm::dmat4 matrix_of(const Parts& parts) {
  const glm::dmat3 turn = glm::mat3_cast(parts.turn);
  return {glm::dvec4(turn[0] * parts.lengths.x, 0.0), glm::dvec4(turn[1] * parts.lengths.y, 0.0),
          glm::dvec4(turn[2] * parts.lengths.z, 0.0), glm::dvec4(parts.place, 1.0)};
}

glm::dvec3 place_of(const CameraKey& key) {
  return glm::dvec3(key.world_from_camera[3]);
}

/// How fast the camera goes from key i to the next.
glm::dvec3 slope(const CameraPath& path, std::size_t i) {
  return (place_of(path.keys[i + 1]) - place_of(path.keys[i])) / (path.keys[i + 1].time - path.keys[i].time);
}

double length_of(const CameraPath& path, std::size_t i) {
  return path.keys[i + 1].time - path.keys[i].time;
}

/// The derivative at a point of the parabola through it and its neighbours, by the slopes and times on both sides.
glm::dvec3 parabola(const glm::dvec3& before, double time_before, const glm::dvec3& after, double time_after) {
  return (before * time_after + after * time_before) / (time_before + time_after);
}

glm::dvec3 velocity(const CameraPath& path, std::size_t i) {
  const std::size_t last = path.keys.size() - 1;
  if (i > 0 && i < last)
    return parabola(slope(path, i - 1), length_of(path, i - 1), slope(path, i), length_of(path, i));
  if (last == 1) return slope(path, 0);
  if (place_of(path.keys.front()) == place_of(path.keys.back()))
    return parabola(slope(path, last - 1), length_of(path, last - 1), slope(path, 0), length_of(path, 0));
  // The parabola through the three keys at this end.
  const std::size_t here = i == 0 ? 0 : last - 1, next = i == 0 ? 1 : last - 2;
  const double a = length_of(path, here), b = length_of(path, next);
  return slope(path, here) + (slope(path, here) - slope(path, next)) * (a / (a + b));
}

glm::dvec3 place_at(const CameraPath& path, std::size_t i, double s) {
  const glm::dvec3 from = place_of(path.keys[i]), to = place_of(path.keys[i + 1]);
  if (path.curve == CameraPath::Curve::linear) return from + s * (to - from);
  const double length = length_of(path, i);
  const glm::dvec3 leaves = length * velocity(path, i), arrives = length * velocity(path, i + 1);
  const double s2 = s * s, s3 = s2 * s;
  return from * (2.0 * s3 - 3.0 * s2 + 1.0) + leaves * (s3 - 2.0 * s2 + s) + to * (3.0 * s2 - 2.0 * s3) +
         arrives * (s3 - s2);
}

}  // namespace

std::string key_complaint(const CameraPath& path, std::size_t i) {
  const CameraKey& key = path.keys[i];
  if (!std::isfinite(key.time)) return fmt::format("keyframe {} of the camera has no time", i + 1);
  if (i > 0 && !(key.time > path.keys[i - 1].time))
    return fmt::format("keyframe {} of the camera is at {} s, which is not later than the one before it, at {} s",
                       i + 1, key.time, path.keys[i - 1].time);
  const glm::dmat4& m = key.world_from_camera;
  if (!is_finite(m) || !(std::abs(glm::determinant(glm::dmat3(m))) > 0.0))
    return fmt::format("the transform of keyframe {} of the camera is not finite and invertible", i + 1);
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 a(m[k]), b(m[(k + 1) % 3]);
    if (std::abs(glm::dot(glm::normalize(a), glm::normalize(b))) > kRightAngle)
      return fmt::format("the transform of keyframe {} of the camera shears it; a path only moves, turns and scales",
                         i + 1);
  }
  if (is_mirrored(m) != is_mirrored(path.keys.front().world_from_camera))
    return fmt::format("keyframe {} of the camera is mirrored and the first one is not, or vice versa", i + 1);
  return "";
}

std::string path_complaint(const CameraPath& path) {
  for (std::size_t i = 0; i < path.keys.size(); ++i) {
    if (std::string complaint = key_complaint(path, i); !complaint.empty()) return complaint;
  }
  return "";
}

glm::dmat4 pose_at(const CameraPath& path, double time) {
  const std::vector<CameraKey>& keys = path.keys;
  if (!(time > keys.front().time)) return keys.front().world_from_camera;
  if (!(time < keys.back().time)) return keys.back().world_from_camera;
  const auto after = std::ranges::upper_bound(keys, time, {}, &CameraKey::time);
  const auto i = static_cast<std::size_t>(after - keys.begin()) - 1;
  if (time == keys[i].time) return keys[i].world_from_camera;
  const double s = (time - keys[i].time) / length_of(path, i);
  const Parts a = parts_of(keys[i].world_from_camera), b = parts_of(keys[i + 1].world_from_camera);
  return matrix_of({.place = place_at(path, i, s),
                    .turn = glm::normalize(glm::slerp(a.turn, b.turn, s)),
                    .lengths = a.lengths + s * (b.lengths - a.lengths)});
}

}  // namespace etendue
