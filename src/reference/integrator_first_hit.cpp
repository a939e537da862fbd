#include <algorithm>
#include <cmath>

#include "reference/frame.h"
#include "reference/integrator.h"
#include "reference/sampling.h"

namespace etendue::reference {
namespace {

/// The light of `simple`: a point of power Φ, that is of intensity Φ/(4π), illuminates a white diffuse surface, whose
/// 1/π is the other factor.
Vec3 simple(const World& world, const Surface& surface, DecisionLog& log) {
  const SimpleLight& light = world.scene().integrator.light;
  const Vec3 to_light = light.position - surface.p;
  const double distance = glm::length(to_light);
  const double cosine = glm::dot(to_light, surface.ns) / distance;
  if (!(cosine > 0.0)) return Vec3(0.0);
  const bool lit = !world.occluded(surface.offset_toward(to_light), light.position);
  log.roulette(lit);
  return lit ? light.energy * (cosine / (4.0 * kPi * kPi * distance * distance)) : Vec3(0.0);
}

/// 1 if a random ray in the hemisphere about the shading normal is unoccluded up to the integrator's length, otherwise
/// 0.
Vec3 openness(const World& world, const Surface& surface, const SampleRandom& random, DecisionLog& log) {
  const Integrator& integrator = world.scene().integrator;
  const SampleRandom::Material numbers = random.material(0);
  const Vec2 u(numbers.u, numbers.v);
  Vec3 local;
  if (integrator.type == Integrator::Type::visibility) {
    const double z = 1.0 - u.x, r = std::sqrt(std::max(0.0, 1.0 - z * z)), phi = 2.0 * kPi * u.y;
    local = {r * std::cos(phi), r * std::sin(phi), z};
  } else {
    local = square_to_cosine_hemisphere(u);
  }
  const Vec3 w = Frame(surface.ns).to_world(local);
  const bool open =
      !world.closest_hit({.origin = surface.offset_toward(w), .direction = w, .t_max = integrator.length});
  log.roulette(open);
  return Vec3(open ? 1.0 : 0.0);
}

Vec3 shade(const World& world, const Surface& surface, const Ray& ray, const SampleRandom& random, DecisionLog& log) {
  switch (world.scene().integrator.type) {
    case Integrator::Type::normals:
      return 0.5 * (surface.ns + 1.0);
    case Integrator::Type::absolute_normals:
      return glm::abs(surface.ns);
    case Integrator::Type::depth:
      return Vec3(1.0 / glm::distance(surface.p, ray.origin));
    case Integrator::Type::distance:
      return Vec3(glm::distance(surface.p, ray.origin) - ray.t_min);
    case Integrator::Type::simple:
      return simple(world, surface, log);
    case Integrator::Type::ambient_occlusion:
    case Integrator::Type::visibility:
      return openness(world, surface, random, log);
    case Integrator::Type::path:
    case Integrator::Type::direct:
    case Integrator::Type::whitted:
    case Integrator::Type::aov:
      break;
  }
  return Vec3(0.0);
}

}  // namespace

Vec3 first_hit_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log) {
  const std::optional<Surface> hit = world.closest_hit(camera_ray);
  log.segment(camera_ray, hit);
  // A camera ray that hits nothing is not occluded.
  const bool open_sky = world.scene().integrator.type == Integrator::Type::visibility;
  const Vec3 color = hit ? shade(world, *hit, camera_ray, random, log) : Vec3(open_sky ? 1.0 : 0.0);
  log.radiance(color);
  return color;
}

}  // namespace etendue::reference
