#include "scene/precision.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>

#include "scene/bounds.h"

namespace etendue {
namespace {

/// Share of a pixel's width that rounding may move a ray.
constexpr double kTolerance = 1.0 / 16.0;

/// Largest and smallest camera depth of a box.
struct Depths {
  double least, most;
};
Depths depths_of(const Bounds& box, const glm::dmat4& camera_from_world) {
  Depths depths{INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 p((corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                       (corner & 4) != 0 ? box.max.z : box.min.z);
    const double depth = (camera_from_world * glm::dvec4(p, 1.0)).z;
    depths = {std::min(depths.least, depth), std::max(depths.most, depth)};
  }
  return depths;
}

/// How wide the pixels of a camera are at a depth, camera units.
double widest_pixel(const Camera& camera, double depth) {
  const double share = camera.window.size.x / camera.width;  // of the film's width
  switch (camera.type) {
    case Camera::Type::perspective:
    case Camera::Type::thin_lens:
      return 2.0 * std::tan(glm::radians(camera.fov) / 2.0) * depth * share;
    case Camera::Type::orthographic:
    case Camera::Type::irradiance_meter:
      return 2.0 * share;
    case Camera::Type::spherical:
      return 2.0 * glm::pi<double>() * std::abs(depth) * share;
    case Camera::Type::radiance_meter:
      break;  // all pixels are the same
  }
  return 0.0;
}

}  // namespace

std::string precision_complaint(const Scene& scene) {
  const Camera& camera = scene.camera;
  const Bounds box = bounds_of(scene);
  if (box.empty() || std::uint64_t{camera.width} * camera.height == 1) return "";
  const glm::dmat4& m = camera.world_from_camera;
  const double depth = std::min(depths_of(box, glm::inverse(m)).most, camera.far_clip);
  const double size = glm::length(box.max - box.min);
  // The size of a pixel at the farthest point; if it is too small there, it is too small everywhere.
  const double pixel = widest_pixel(camera, depth) * glm::length(glm::dvec3(m[0]));
  if (!(pixel > 0.0) || !(size > 0.0)) return "";
  // Positions are rounded, relative to the scene's size in single precision; in double precision to the coordinates.
  const glm::dvec3 eye(m[3]);
  const double largest = std::max({std::abs(eye.x), std::abs(eye.y), std::abs(eye.z), size});
  const double single_error = size * 0x1p-24, double_error = largest * 0x1p-52;
  const double error = std::max(single_error, double_error);
  if (pixel * kTolerance >= error) return "";
  const bool hopeless = pixel * kTolerance < double_error;
  return fmt::format(
      "a pixel is at most {:.1e} wide where the scene is, {:.0e} of the scene's size of {:.3g}; {}", pixel,
      pixel / size, size,
      hopeless ? "not even double precision can tell its pixels apart, and the picture cannot be trusted: widen the "
                 "field of view, or move camera and scene nearer to the origin"
               : "single precision, in which devices compute, cannot tell its pixels apart, and the picture cannot be "
                 "trusted: widen the field of view, or use --device reference");
}

}  // namespace etendue
