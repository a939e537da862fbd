/// Scenes that ask what a camera makes of an emitting rectangle.

#include <algorithm>

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

/// A rectangle on the film, in pixels from the centre of the only pixel. It is missed, and hit, often enough.
struct FilmRectangle {
  double x0 = 0.0, x1 = 0.0, y0 = 0.0, y1 = 0.0;
  double covered = 0.0;  ///< share of the pixel's filter

  FilmRectangle(Dice& dice, const ReconstructionFilter& filter) {
    const auto share = [&](double from, double to) { return filter_share(filter, to) - filter_share(filter, from); };
    while (covered < 0.05 || covered > 0.95) {
      x0 = dice.between(-1.0, 0.1), x1 = dice.between(0.15, 1.2);
      y0 = dice.between(-1.2, 0.0), y1 = dice.between(0.1, 1.0);
      covered = share(x0, x1) * share(y0, y1);
    }
  }
  /// The rectangle at camera depth `depth`, where a pixel is `pixel` wide and high, facing the camera.
  TriangleMesh at(const Camera& camera, double depth, double pixel) const {
    std::vector<dvec3> corners;
    for (const glm::dvec2& film : {glm::dvec2(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}})
      corners.emplace_back(camera.world_from_camera * glm::dvec4(-pixel * film.x, -pixel * film.y, depth, 1.0));
    const dvec3 forward(camera.world_from_camera[2]);
    if (glm::dot(glm::cross(corners[1] - corners[0], corners[2] - corners[0]), forward) > 0.0)
      std::ranges::reverse(corners);
    return polygon_mesh(corners);
  }
};

/// A camera up to a million scene sizes away whose pixel is as wide as the scene. What lies before the near and beyond
/// the far clipping plane, a scene size from the rectangle, must not be seen.
ClosedFormScene far_rectangle(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  Camera& camera = scene.camera;
  const double distance = dice.log_between(1e2, 1e6), pixel = dice.between(0.5, 1.5);
  const dvec3 direction = dice.direction();
  camera = look_along(-distance * direction, direction, std::atan(0.5 * pixel / distance) * 360.0 / kPi);
  camera.filter = random_filter(dice);
  camera.near_clip = distance - 1.0;
  camera.far_clip = distance + 1.0;
  const FilmRectangle rectangle(dice, camera.filter);
  const dvec3 radiance = dice.color(0.2, 2.0);
  add_shape(scene, rectangle.at(camera, distance, pixel), DiffuseBsdf{dvec3(0.5)}, radiance);
  add_shape(scene, square(-1.5 * direction, direction, 4.0), DiffuseBsdf{dvec3(0.5)}, radiance);
  add_shape(scene, square(1.5 * direction, -direction, 4.0), DiffuseBsdf{dvec3(0.5)}, radiance);
  scene.integrator.max_depth = 1;
  move_scene(scene, dice, true);
  result.expected = rectangle.covered * luminance(radiance);
  result.name = fmt::format("far rectangle, {:.1e} away", distance);
  return result;
}

}  // namespace

ClosedFormScene camera_scene(Dice& dice) {
  return far_rectangle(dice);
}

}  // namespace etendue::closed_form
