/// Scenes in which a camera sees an emitting rectangle.

#include <algorithm>
#include <array>

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
  constexpr std::array<const char*, 5> kNames{"box", "tent", "gaussian", "mitchell", "lanczos"};
  result.name = fmt::format("far rectangle, {} filter, {:.1e} away",
                            kNames[static_cast<std::size_t>(camera.filter.type)], distance);
  return result;
}

/// A rectangle before a camera that sees everything in its true size, at a random scale of the camera's axes.
ClosedFormScene orthographic_rectangle(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  Camera& camera = scene.camera;
  const double half_width = dice.between(0.3, 2.0);
  camera = look_along(dice.color(-1.0, 1.0), dice.direction(), 1.0);
  for (int a = 0; a < 3; ++a) camera.world_from_camera[a] *= half_width;
  camera.type = Camera::Type::orthographic;
  camera.filter = random_filter(dice);
  const FilmRectangle rectangle(dice, camera.filter);
  const dvec3 radiance = dice.color(0.2, 2.0);
  add_shape(scene, rectangle.at(camera, dice.log_between(0.5, 50.0), 2.0), DiffuseBsdf{dvec3(0.5)}, radiance);
  scene.integrator.max_depth = 1;
  move_scene(scene, dice, true);
  for (int a = 0; a < 3; ++a)  // move_scene leaves the length of a camera's axes as it is
    camera.world_from_camera[a] *= glm::length(dvec3(scene.instances[0].world_from_object[0]));
  result.expected = rectangle.covered * luminance(radiance);
  result.name = "orthographic rectangle";
  return result;
}

/// Corners of the aperture of radius 1; many of them for a disk.
std::vector<glm::dvec2> aperture_corners(const Aperture& aperture) {
  const std::uint32_t count = aperture.blades > 0 ? aperture.blades : 20000;
  std::vector<glm::dvec2> corners;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count + aperture.rotation * kPi / 180.0;
    corners.emplace_back(std::cos(angle), std::sin(angle));
  }
  return corners;
}

/// Share of a convex polygon with x > `edge`, by its corners.
double share_beyond(const std::vector<glm::dvec2>& corners, double edge) {
  const auto area = [](const std::vector<glm::dvec2>& p) {
    double sum = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const glm::dvec2 &a = p[i], &b = p[(i + 1) % p.size()];
      sum += a.x * b.y - b.x * a.y;
    }
    return std::abs(sum) / 2.0;
  };
  std::vector<glm::dvec2> kept;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec2 &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if (a.x > edge) kept.push_back(a);
    if ((a.x > edge) != (b.x > edge)) kept.push_back(glm::mix(a, b, (edge - a.x) / (b.x - a.x)));
  }
  return area(kept) / area(corners);
}

/// A thin lens looks at one point of the plane in focus. Elsewhere that point is a spot of the aperture's shape, of
/// radius r |1 − z/f|: the circle of confusion; the edge of an emitting rectangle cuts it.
ClosedFormScene circle_of_confusion(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  Camera& camera = scene.camera;
  camera = look_along(dice.color(-1.0, 1.0), dice.direction(), kPointFov);
  camera.type = Camera::Type::thin_lens;
  camera.aperture = {.radius = dice.between(0.05, 0.3),
                     .focus_distance = dice.between(1.0, 4.0),
                     .blades = dice.chance(0.5) ? static_cast<std::uint32_t>(dice.between_int(3, 8)) : 0,
                     .rotation = dice.between(0.0, 90.0)};
  const double f = camera.aperture.focus_distance, depth = f * (dice.chance(0.5) ? 0.6 : 1.7);
  const double spread = 1.0 - depth / f;  // negative beyond the focus: the spot is upside down
  std::vector<glm::dvec2> corners = aperture_corners(camera.aperture);
  if (spread < 0.0) {
    for (glm::dvec2& corner : corners) corner = -corner;
  }
  double edge = 0.0, lit = 0.0;  // in radii of the spot
  while (lit < 0.05 || lit > 0.95) {
    edge = dice.between(-0.8, 0.8);
    lit = share_beyond(corners, edge);
  }
  const double radius = camera.aperture.radius * std::abs(spread);
  std::vector<dvec3> rectangle;
  for (const glm::dvec2& p : {glm::dvec2(edge, -2.0), {edge, 2.0}, {3.0, 2.0}, {3.0, -2.0}})
    rectangle.emplace_back(camera.world_from_camera * glm::dvec4(radius * p, depth, 1.0));
  const dvec3 forward(camera.world_from_camera[2]);
  if (glm::dot(glm::cross(rectangle[1] - rectangle[0], rectangle[2] - rectangle[0]), forward) > 0.0)
    std::ranges::reverse(rectangle);
  const dvec3 radiance = dice.color(0.2, 2.0);
  add_shape(scene, polygon_mesh(rectangle), DiffuseBsdf{dvec3(0.5)}, radiance);
  scene.integrator.max_depth = 1;
  result.expected = lit * luminance(radiance);
  result.name = fmt::format("circle of confusion, {} corners", camera.aperture.blades);
  return result;
}

/// A panorama of a sphere around the upper pole, which takes the part of the film's height that its angle is of 180°.
ClosedFormScene panorama_of_a_cap(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  scene.camera.type = Camera::Type::spherical;
  scene.camera.width = 8;
  scene.camera.height = 4;
  const double angle = dice.between(0.3, 1.3), distance = dice.between(1.0, 3.0);
  const dvec3 radiance = dice.color(0.2, 2.0);
  add_shape(scene, Sphere{{0, distance, 0}, distance * std::sin(angle)}, DiffuseBsdf{dvec3(0.5)}, radiance);
  scene.integrator.max_depth = 1;
  move_scene(scene, dice, true);
  result.expected = angle / kPi * luminance(radiance);
  result.name = "panorama of a cap";
  return result;
}

/// The irradiance of a tiny square under a polygon, as measured by a meter: Lambert's formula.
ClosedFormScene metered_polygon(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  double irradiance = 0.0;
  while (irradiance < 0.1) {
    scene = Scene{};
    const dvec3 d = dice.direction_around({0, 0, 1}, 0.1);
    const TriangleMesh polygon = square(dice.between(0.5, 1.0) * d, -d, dice.between(0.3, 0.9));
    irradiance = polygon_irradiance(corners_of(polygon), {0, 0, 1});
    add_shape(scene, polygon, DiffuseBsdf{dvec3(0.0)}, dvec3(1.0, 0.7, 0.4));
  }
  scene.camera = look_along(dvec3(0.0), {0, 0, 1}, 1.0);
  for (int a = 0; a < 3; ++a) scene.camera.world_from_camera[a] *= 1e-4;
  scene.camera.type = Camera::Type::irradiance_meter;
  scene.integrator.max_depth = 1;
  move_scene(scene, dice, true);
  const double scale = glm::length(dvec3(scene.instances[0].world_from_object[0]));
  for (int a = 0; a < 3; ++a) scene.camera.world_from_camera[a] *= scale;
  scene.camera.near_clip = 1e-4;  // in units of the meter's axes, which have been scaled
  scene.camera.far_clip = 1e6;
  result.expected = irradiance * luminance(dvec3(1.0, 0.7, 0.4));
  result.name = "metered polygon";
  return result;
}

}  // namespace

ClosedFormScene camera_scene(Dice& dice) {
  switch (dice.below(6)) {
    case 0:
      return orthographic_rectangle(dice);
    case 1:
    case 2:
      return circle_of_confusion(dice);
    case 3:
      return panorama_of_a_cap(dice);
    case 4:
      return metered_polygon(dice);
    default:
      return far_rectangle(dice);
  }
}

}  // namespace etendue::closed_form
