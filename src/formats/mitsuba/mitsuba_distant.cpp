#include "formats/mitsuba/mitsuba_distant.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace etendue {
namespace {

/// What the rays are aimed at. The half axes are 0 for a point.
struct Target {
  enum class Shape { point, rectangle, disk };
  Shape shape = Shape::disk;
  glm::dvec3 center{0.0}, x{1, 0, 0}, y{0, 1, 0};
};

/// The cross-section of the sphere around the box of all shapes.
Target whole_scene(const Bounds& bounds, const glm::dvec3& direction, double radius) {
  const glm::dvec3 helper = std::abs(direction.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  const glm::dvec3 x = glm::normalize(glm::cross(helper, direction));
  const glm::dvec3 center = bounds.empty() ? glm::dvec3(0.0) : 0.5 * (bounds.min + bounds.max);
  return {Target::Shape::disk, center, radius * x, radius * glm::cross(direction, x)};
}

std::optional<Target> read_target(const MitsubaObject& sensor, const MitsubaContext& context) {
  if (sensor.given("target")) return Target{.shape = Target::Shape::point, .center = sensor.triple("target")};
  const std::vector<const XmlElement*> shapes = sensor.children("shape");
  if (shapes.empty()) return std::nullopt;
  const auto shape = MitsubaObject::read(*shapes.front(), context, "the origin");
  if (!shape) return Target{.shape = Target::Shape::point};
  if (shape->type() != "rectangle" && shape->type() != "disk") {
    context.missing.add(fmt::format("distant that aims at a {}", shape->type()), shape->position(), "its origin");
    return Target{.shape = Target::Shape::point, .center = glm::dvec3(shape->matrix("to_world")[3])};
  }
  const glm::dmat4 m = shape->matrix("to_world");
  return Target{shape->type() == "disk" ? Target::Shape::disk : Target::Shape::rectangle, glm::dvec3(m[3]),
                glm::dvec3(m[0]), glm::dvec3(m[1])};
}

}  // namespace

void set_distant_camera(const MitsubaObject& sensor, const Bounds& bounds, const MitsubaContext& context,
                        Camera& camera) {
  glm::dvec3 direction(sensor.matrix("to_world")[2]);
  if (sensor.given("direction")) direction = sensor.triple("direction");
  if (!(glm::length(direction) > 0.0))
    return context.sink.error(sensor.position_of("direction"), "the direction has length 0; give another one");
  direction = glm::normalize(direction);
  const double radius = bounds.empty() ? 1.0 : std::max(0.5 * glm::distance(bounds.min, bounds.max), 1e-6);
  const Target target = read_target(sensor, context).value_or(whole_scene(bounds, direction, radius));
  // The axes of a camera that looks along the direction through a square or round window as large as the target.
  const double size =
      target.shape == Target::Shape::point ? 1.0 : std::max(glm::length(target.x), glm::length(target.y));
  const glm::dvec3 z = size * direction;
  Target axes = target;
  if (target.shape == Target::Shape::point) axes = whole_scene(bounds, direction, 1.0);
  const double area = glm::dot(glm::cross(axes.x, axes.y), direction);
  if (!(std::abs(area) > 1e-9 * size * size))
    return context.sink.error(sensor.position(),
                              "the sensor looks along the surface that it aims at; turn one of them");
  camera.world_from_camera = {glm::dvec4(axes.x, 0), glm::dvec4(axes.y, 0), glm::dvec4(z, 0),
                              glm::dvec4(target.center - 2.0 * radius * direction, 1)};
  camera.near_clip = 0.0;
  camera.far_clip = 1e6 * std::max(1.0, radius / size);
  camera.filter = {};  // positions on the film have no meaning
  switch (target.shape) {
    case Target::Shape::point:
      camera.type = Camera::Type::radiance_meter;
      break;
    case Target::Shape::rectangle:
      camera.type = Camera::Type::orthographic;
      break;
    case Target::Shape::disk:
      // A lens that is focused on a point at infinity has parallel rays through a disk.
      camera.type = Camera::Type::thin_lens;
      camera.aperture = {.radius = 1.0, .focus_distance = 1e9};
      camera.fov = 1e-7;
      break;
  }
}

}  // namespace etendue
