/// Scenes for AOVs.

#include <fmt/format.h>

#include "scene/view.h"
#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

/// The mean of f over the camera's only pixel, directions not normalised: one unit along camera +Z.
template <typename F>
dvec3 pixel_mean(const Camera& camera, const F& f) {
  constexpr int kSteps = 400;
  const double slope = std::tan(camera.fov * kPi / 360.0);
  const glm::dmat3 axes(camera.world_from_camera);
  dvec3 sum(0.0);
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps; ++k) {
      const auto at = [](int step) { return 2.0 * (step + 0.5) / kSteps - 1.0; };
      sum += f(axes * dvec3(slope * at(i), slope * at(k), 1.0));
    }
  }
  return sum / static_cast<double>(kSteps * kSteps);
}

dvec3 world_point(const Scene& scene, std::size_t vertex) {
  const dvec3& p = std::get<TriangleMesh>(scene.shapes[0]).positions[vertex];
  return dvec3(scene.instances[0].world_from_object * glm::dvec4(p, 1.0));
}

/// How far a slanted wall is that fills the pixel, or where.
ClosedFormScene slanted_wall(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  scene.camera = look_along(dice.color(-1.0, 1.0), dice.direction(), dice.between(20.0, 60.0));
  const dvec3 forward(scene.camera.world_from_camera[2]), eye(scene.camera.world_from_camera[3]);
  const dvec3 n = dice.direction_around(-forward, 0.8);
  add_shape(scene, square(eye + dice.between(0.5, 2.0) * forward, n, 100.0), DiffuseBsdf{});
  const Aov aov = dice.chance(0.5) ? Aov::depth : Aov::position;
  scene.integrator.type = Integrator::Type::aov;
  scene.integrator.aov = aov;
  move_scene(scene, dice, true);
  const dvec3 origin(scene.camera.world_from_camera[3]), p = world_point(scene, 0);
  const dvec3 normal = glm::normalize(glm::cross(world_point(scene, 1) - p, world_point(scene, 2) - p));
  const dvec3 mean = pixel_mean(scene.camera, [&](const dvec3& v) {
    const dvec3 d = glm::normalize(v);
    const double t = glm::dot(p - origin, normal) / glm::dot(d, normal);
    return aov == Aov::depth ? dvec3(t, 0.0, 0.0) : origin + t * d;
  });
  result.expected = luminance(mean);
  result.name = fmt::format("aov {} of a slanted wall", traits(aov).name);
  return result;
}

/// The fraction of a pixel covered by a rectangle, for any filter.
ClosedFormScene alpha_of_rectangle(Dice& dice) {
  ClosedFormScene result = coverage_scene(dice);
  Scene& scene = result.scene;
  result.expected /= luminance(scene.emitters[0].radiance.value);
  scene.integrator.type = Integrator::Type::aov;
  scene.integrator.aov = Aov::alpha;
  result.name = "aov alpha of a " + result.name;
  return result;
}

/// A diffuse wall seen in a mirror.
ClosedFormScene mirrored_wall(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 wo = dice.direction_around({0, 1, 0}, 0.3), reflected(-wo.x, wo.y, -wo.z);
  const dvec3 n = dice.direction_around(-reflected, 0.3), albedo = dice.color(0.1, 0.9);
  add_shape(scene, square(dvec3(0.0), {0, 1, 0}, 0.1), MirrorBsdf{});
  add_shape(scene, square(2.0 * reflected, n, 0.5), DiffuseBsdf{albedo});
  scene.camera = look_along(0.7 * wo, -wo, kPointFov);
  const bool normal = dice.chance(0.5);
  scene.integrator.type = Integrator::Type::aov;
  scene.integrator.aov = normal ? Aov::normal : Aov::albedo;
  move_scene(scene, dice, true);
  const dvec3 turned = glm::normalize(glm::dmat3(scene.instances[1].world_from_object) * n);
  result.expected = luminance(normal ? turned : albedo);
  result.name = fmt::format("aov {} in a mirror", traits(scene.integrator.aov).name);
  return result;
}

/// A wall that fills the pixel, by its number: of each set of paths the first one tells it.
ClosedFormScene numbered_wall(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  scene.camera = look_along(dvec3(0.0), dice.direction(), 40.0);
  const dvec3 forward(scene.camera.world_from_camera[2]);
  const int others = dice.between_int(0, 4);
  for (int i = 0; i < others; ++i) add_shape(scene, square(-(1.0 + i) * forward, forward, 1.0), MirrorBsdf{});
  add_shape(scene, square(forward, -forward, 10.0), DiffuseBsdf{});
  scene.sampler = {Sampler::Type::sobol, 16, static_cast<std::uint32_t>(dice.between_int(1, 4))};
  scene.integrator.type = Integrator::Type::aov;
  const bool instance = dice.chance(0.5);
  scene.integrator.aov = instance ? Aov::instance : Aov::material;
  move_scene(scene, dice, true);
  result.expected = luminance({others + 1.0, 0.0, 0.0});
  result.name = fmt::format("aov {} {}", traits(scene.integrator.aov).name, others + 1);
  return result;
}

/// Parts of the geometric series of an emitting, reflecting box.
ClosedFormScene parts_of_furnace(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result = furnace_scene(dice, strategy);
  Scene& scene = result.scene;
  const bool direct = dice.chance(0.5);
  scene.integrator.max_depth = static_cast<std::uint32_t>(dice.between_int(3, 10));
  scene.integrator.light_part = direct ? Integrator::LightPart::direct : Integrator::LightPart::indirect;
  const dvec3 albedo = std::get<DiffuseBsdf>(scene.materials[0].bsdf).albedo.value;
  dvec3 sum(0.0), power(1.0);
  for (std::uint32_t i = 0; i < scene.integrator.max_depth; ++i, power *= albedo) {
    if ((i < 2) == direct) sum += power;
  }
  result.expected = luminance(sum * scene.emitters[0].radiance.value);
  result.name = fmt::format("{} light of a {}", direct ? "direct" : "indirect", result.name);
  return result;
}

/// A rectangle under an even sky that the camera does not see.
ClosedFormScene hidden_background(Dice& dice) {
  ClosedFormScene result = coverage_scene(dice);
  Scene& scene = result.scene;
  const double covered = result.expected / luminance(scene.emitters[0].radiance.value);
  const dvec3 sky = dice.color(0.2, 2.0), albedo = dice.color(0.1, 0.9);
  scene.emitters.clear();
  scene.instances[0].emitter.reset();
  scene.materials[0].bsdf = DiffuseBsdf{albedo};
  scene.sky.top = scene.sky.horizon = sky;
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  scene.integrator.hide_background = true;
  result.expected = covered * luminance(albedo * sky);
  result.name = "hidden sky behind a " + result.name;
  return result;
}

}  // namespace

ClosedFormScene aov_scene(Dice& dice, LightStrategy strategy) {
  switch (dice.below(6)) {
    case 0:
      return slanted_wall(dice);
    case 1:
      return alpha_of_rectangle(dice);
    case 2:
      return mirrored_wall(dice);
    case 3:
      return numbered_wall(dice);
    case 4:
      return hidden_background(dice);
    default:
      return parts_of_furnace(dice, strategy);
  }
}

}  // namespace etendue::closed_form
