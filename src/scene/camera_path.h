#pragma once
/// Moving cameras: keyframes, and interpolation between them. docs/cameras.md, "Paths".

#include <cstddef>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

struct CameraKey {
  double time = 0.0;                  ///< seconds
  glm::dmat4 world_from_camera{1.0};  ///< affine, its axes at right angles
};

struct CameraPath {
  /// Between keys the place of the camera follows straight lines, or a cubic spline.
  enum class Curve { linear, spline };
  Curve curve = Curve::spline;
  std::vector<CameraKey> keys;  ///< times increase

  bool empty() const { return keys.empty(); }
};

/// What is wrong with a key, given the previous ones, as a sentence without a full stop; "" if nothing is. Wrong are a
/// time that is not a number or not later than the previous one, axes that are not at right angles, and a key that is
/// mirrored if the first is not, or vice versa.
std::string key_complaint(const CameraPath& path, std::size_t key);
/// The first of all keys.
std::string path_complaint(const CameraPath& path);

/// world_from_camera at a time in seconds; before the first key and behind the last one that of the key. Rotations are
/// interpolated along the shortest arc [Shoemake1985], lengths of axes linearly. Places follow straight lines, or a
/// cubic through the keys whose derivative at a key is that of the parabola through it and its neighbours; it is exact
/// for places that are a quadratic of the time, and smooth across the ends of a path that ends where it begins. The
/// path must have a key and no complaint.
glm::dmat4 pose_at(const CameraPath& path, double time);

}  // namespace etendue
