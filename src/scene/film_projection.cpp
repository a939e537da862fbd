#include "scene/film_projection.h"

#include <algorithm>
#include <cmath>

#include "image/vectors.h"

namespace etendue {
namespace {

/// Half of the whole film's width at depth 1 over the tangent of half the field of view.
double width_share(Camera::FovAxis axis, double aspect) {
  switch (axis) {
    case Camera::FovAxis::x:
      return 1.0;
    case Camera::FovAxis::y:
      return 1.0 / aspect;
    case Camera::FovAxis::diagonal:
      return 1.0 / std::hypot(1.0, aspect);
    case Camera::FovAxis::smaller:
      return 1.0 / std::min(1.0, aspect);
    case Camera::FovAxis::larger:
      return 1.0 / std::max(1.0, aspect);
  }
  return 1.0;
}

/// Fractions of the whole film, from its upper left corner, as pixels of the part that is rendered.
glm::dvec2 pixels_of(const Camera& camera, const glm::dvec2& fraction) {
  const FilmWindow& window = camera.window;
  return (fraction - window.origin - window.principal_offset) / window.size * glm::dvec2(camera.width, camera.height);
}

}  // namespace

std::optional<FilmProjection> film_projection(const Camera& camera) {
  using Type = Camera::Type;
  const glm::dmat4 camera_from_world = glm::inverse(camera.world_from_camera);
  if (camera.type == Type::spherical) return FilmProjection{FilmProjection::Kind::sphere, camera_from_world};
  const bool parallel = camera.type == Type::orthographic;
  if (!parallel && camera.type != Type::perspective && camera.type != Type::thin_lens) return std::nullopt;
  const double aspect = film_aspect(camera);
  const double x = parallel ? 1.0 : std::tan(0.5 * glm::radians(camera.fov)) * width_share(camera.fov_axis, aspect);
  // Half the film to each side of its middle, x to the left and y up.
  const glm::dvec2 middle = pixels_of(camera, glm::dvec2(0.5));
  const glm::dvec2 slope = (pixels_of(camera, glm::dvec2(0.0)) - middle) / glm::dvec2(x, x * aspect);
  glm::dmat4 pixels_from_camera(0.0);
  pixels_from_camera[0][0] = slope.x;
  pixels_from_camera[1][1] = slope.y;
  pixels_from_camera[2][2] = 1.0;
  glm::dvec4& share = pixels_from_camera[parallel ? 3 : 2];  // what w is
  share.x = middle.x;
  share.y = middle.y;
  share.w = 1.0;
  return FilmProjection{FilmProjection::Kind::plane, pixels_from_camera * camera_from_world};
}

glm::dvec2 sphere_place(const Camera& camera, const glm::dvec3& p) {
  const double longitude = std::atan2(p.x, p.z), polar = std::atan2(std::hypot(p.x, p.z), p.y);
  return pixels_of(camera, {0.5 - 0.5 * longitude / kPi, polar / kPi});
}

std::optional<glm::dvec2> film_place(const Camera& camera, const glm::dvec3& point) {
  const std::optional<FilmProjection> projection = film_projection(camera);
  if (!projection) return std::nullopt;
  const glm::dvec4 h = projection->matrix * glm::dvec4(point, 1.0);
  if (projection->kind == FilmProjection::Kind::sphere)
    return glm::length(glm::dvec3(h)) > 0.0 ? std::optional(sphere_place(camera, glm::dvec3(h))) : std::nullopt;
  return h.w > 0.0 ? std::optional(glm::dvec2(h) / h.w) : std::nullopt;
}

}  // namespace etendue
