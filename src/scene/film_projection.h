#pragma once
/// The projection of world points into a camera's picture.

#include <optional>

#include "scene/scene.h"

namespace etendue {

/// What makes pixels of points. A point p of the world becomes h = `matrix` · (p, 1), a direction d at infinity
/// `matrix` · (d, 0).
struct FilmProjection {
  /// On a plane (x, y)/w is the place on the film in pixels from its upper left corner, and w > 0 before the camera;
  /// straight lines stay straight. On a sphere h is the point in camera space, longitude and polar angle of which are
  /// the place on the film: see sphere_place().
  enum class Kind { plane, sphere };
  Kind kind = Kind::plane;
  glm::dmat4 matrix{1.0};
};

/// Of a lens the projection through its middle. Nothing for meters, which see no picture.
std::optional<FilmProjection> film_projection(const Camera& camera);

/// The place on the film of a camera that sees all directions, `in_camera` being in camera space.
glm::dvec2 sphere_place(const Camera& camera, const glm::dvec3& in_camera);

/// The place of a point on the film; nothing where it has none, behind the camera for instance.
std::optional<glm::dvec2> film_place(const Camera& camera, const glm::dvec3& point);

}  // namespace etendue
