#include "reference/camera.h"

#include <algorithm>
#include <cmath>

#include "reference/frame.h"
#include "reference/sampling.h"

namespace etendue::reference {
namespace {

/// A film position as fractions of the whole film, from its upper left corner, moved by the principal point.
Vec2 film_fraction(const Camera& camera, const Vec2& film) {
  const FilmWindow& window = camera.window;
  return {window.origin.x + window.principal_offset.x + window.size.x * film.x / camera.width,
          window.origin.y + window.principal_offset.y + window.size.y * film.y / camera.height};
}

/// Half of the whole film's width at depth 1.
double half_width(const Camera& camera) {
  const double half = std::tan(glm::radians(camera.fov) / 2.0);
  const double aspect = film_aspect(camera);
  switch (camera.fov_axis) {
    case Camera::FovAxis::x:
      break;
    case Camera::FovAxis::y:
      return half / aspect;
    case Camera::FovAxis::diagonal:
      return half / std::hypot(1.0, aspect);
    case Camera::FovAxis::smaller:
      return half / std::min(1.0, aspect);
    case Camera::FovAxis::larger:
      return half / std::max(1.0, aspect);
  }
  return half;
}

/// A point of the aperture, camera units: a disk, or a polygon as triangles about its centre.
Vec2 aperture_point(const Aperture& aperture, const SampleRandom::Lens& random) {
  const Vec2 u(random.u, random.v);
  if (aperture.blades == 0) return aperture.radius * square_to_disk(u);
  const double n = aperture.blades;
  const double first = std::floor(random.blade * n);
  const auto corner = [&](double i) {
    const double angle = glm::radians(aperture.rotation) + 2.0 * kPi * i / n;
    return Vec2(std::cos(angle), std::sin(angle));
  };
  const Vec3 weights = square_to_triangle(u);
  return aperture.radius * (weights.y * corner(first) + weights.z * corner(first + 1.0));
}

/// A ray in camera space; `direction` is as long as the unit of the clipping distances.
struct LocalRay {
  Vec3 origin{0.0};
  Vec3 direction{0.0, 0.0, 1.0};
};

LocalRay local_ray(const Camera& camera, const Vec2& film, const SampleRandom::Lens& lens) {
  const Vec2 at = film_fraction(camera, film);
  const Vec2 ndc(1.0 - 2.0 * at.x, 1.0 - 2.0 * at.y);
  switch (camera.type) {
    case Camera::Type::perspective:
    case Camera::Type::thin_lens: {
      const double tan_x = half_width(camera), tan_y = tan_x * film_aspect(camera);
      const Vec3 direction(tan_x * ndc.x, tan_y * ndc.y, 1.0);
      if (camera.type == Camera::Type::perspective) return {.direction = direction};
      // All points of the lens see the same point of the plane in focus.
      const Vec3 start(aperture_point(camera.aperture, lens), 0.0);
      const double focus = camera.aperture.focus_distance;
      return {.origin = start, .direction = (focus * direction - start) / focus};
    }
    case Camera::Type::orthographic:
      return {.origin = {ndc.x, film_aspect(camera) * ndc.y, 0.0}};
    case Camera::Type::irradiance_meter:
      return {.origin = {ndc.x, ndc.y, 0.0}};
    case Camera::Type::radiance_meter:
      break;
    case Camera::Type::spherical: {
      const double longitude = kPi * ndc.x, polar = kPi * at.y;
      return {
          .direction = {std::sin(longitude) * std::sin(polar), std::cos(polar), std::cos(longitude) * std::sin(polar)}};
    }
  }
  return {};
}

}  // namespace

Ray camera_ray(const Camera& camera, const Vec2& film, const SampleRandom::Lens& lens) {
  const LocalRay local = local_ray(camera, film, lens);
  const glm::dmat3 axes(camera.world_from_camera);
  Vec3 world = axes * local.direction;
  // One unit along `world` is one camera unit along camera +Z, which is how the clipping planes are measured.
  const double length = glm::length(world);
  if (camera.type == Camera::Type::irradiance_meter) {
    const Vec3 normal = glm::normalize(glm::cross(axes[0], axes[1]));
    const Vec3 n = glm::dot(normal, axes[2]) < 0.0 ? -normal : normal;
    world = length * Frame(n).to_world(square_to_cosine_hemisphere({lens.u, lens.v}));
  }
  return {.origin = Vec3(camera.world_from_camera * glm::dvec4(local.origin, 1.0)),
          .direction = world / length,
          .t_min = camera.near_clip * length,
          .t_max = camera.far_clip * length};
}

double camera_weight(const Camera& camera) {
  return camera.type == Camera::Type::irradiance_meter ? kPi : 1.0;
}

}  // namespace etendue::reference
