#include "reference/integrator.h"

namespace etendue::reference {

Vec3 normals_radiance(const World& world, const Ray& camera_ray, DecisionLog& log) {
  const std::optional<Surface> hit = world.closest_hit(camera_ray);
  log.segment(hit);
  const Vec3 color = hit ? 0.5 * (hit->ns + 1.0) : Vec3(0.0);
  log.radiance(color);
  return color;
}

}  // namespace etendue::reference
