#include "reference/camera.h"

#include <cmath>

namespace etendue::reference {

Ray camera_ray(const Camera& camera, const Vec2& film) {
  const double width = camera.width;
  const double height = camera.height;
  const double tan_x = std::tan(glm::radians(camera.fov) / 2.0);
  const double tan_y = tan_x * height / width;
  const Vec3 local(tan_x * (1.0 - 2.0 * film.x / width), tan_y * (1.0 - 2.0 * film.y / height), 1.0);
  const Vec3 world = glm::dmat3(camera.world_from_camera) * local;
  // One unit along `world` is one camera unit along camera +Z, which is how the clipping planes are measured.
  const double length = glm::length(world);
  return {.origin = Vec3(camera.world_from_camera[3]),
          .direction = world / length,
          .t_min = camera.near_clip * length,
          .t_max = camera.far_clip * length};
}

}  // namespace etendue::reference
