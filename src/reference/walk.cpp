#include "reference/walk.h"

#include <algorithm>
#include <cmath>

namespace etendue::reference {

void go_behind(const Surface& surface, Ray& ray) {
  ray.t_min = surface.t;
  // By the distance that the next surface lies behind the point where a ray begins, see offset_toward().
  const double cosine = std::max(0.01, std::abs(glm::dot(ray.direction, surface.ng)));
  ray.passed = {surface.instance, surface.t + glm::distance(surface.offset_toward(surface.ng), surface.p) / cosine};
}

std::optional<Surface> first_visible(const World& world, Ray& ray, const Vec3& gathered, DecisionLog& log) {
  for (;;) {
    const std::optional<Surface> hit = world.closest_hit(ray);
    log.segment(ray, hit);
    if (!hit || !world.scene().integrator.hide_emitters) return hit;
    const AreaEmitter* emitter = world.scene().emitter_of(world.scene().instances[hit->instance]);
    if (emitter == nullptr || is_zero(emitter->radiance.value)) return hit;
    log.radiance(gathered);
    const double passed = glm::dot(hit->p - ray.origin, ray.direction);
    ray = {.origin = hit->offset_toward(ray.direction), .direction = ray.direction, .t_max = ray.t_max - passed};
  }
}

}  // namespace etendue::reference
