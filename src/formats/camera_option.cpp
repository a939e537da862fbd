#include "formats/camera_option.h"

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "core/errors.h"
#include "formats/dialect/values.h"

namespace etendue {

bool is_camera_placement(const std::string& text) {
  try {
    return parse_numbers(text).size() > 1;
  } catch (const ValueError&) {
    return false;
  }
}

void set_camera(const std::string& text, Scene& scene, Diagnostics& diagnostics) {
  const auto refuse = [&](const std::string& why) {
    diagnostics.error({}, fmt::format("--camera {}: {}", text, why), ErrorKind::usage);
  };
  std::vector<ListedNumber> n;
  try {
    n = parse_numbers(text);
  } catch (const ValueError& error) {
    return refuse(error.message);
  }
  if (n.size() != 6 && n.size() != 7)
    return refuse(fmt::format(
        "{} numbers; write 3 for the eye, 3 for its target and optionally a field of view in degrees", n.size()));
  const glm::dvec3 eye(n[0].value, n[1].value, n[2].value), target(n[3].value, n[4].value, n[5].value);
  const double distance = glm::distance(eye, target);
  if (!(distance > 0.0)) return refuse("the eye looks at itself; move one of the points");
  const glm::dvec3 z = (target - eye) / distance;
  const glm::dvec3 up = std::abs(z.y) < 0.999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 x = glm::normalize(glm::cross(up, z));
  Camera& camera = scene.camera;
  camera.type = Camera::Type::perspective;
  camera.aperture = {};
  camera.window = {};
  if (n.size() == 7) {
    if (!(n[6].value > 0.0 && n[6].value < 180.0)) return refuse("the field of view is not between 0 and 180 degrees");
    camera.fov = n[6].value;
    camera.fov_axis = Camera::FovAxis::x;
  }
  camera.path.keys.clear();
  camera.world_from_camera = {glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0), glm::dvec4(z, 0), glm::dvec4(eye, 1)};
}

}  // namespace etendue
