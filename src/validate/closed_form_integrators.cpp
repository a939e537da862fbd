/// Scenes that ask what integrators other than path say.

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

/// A point of a floor, seen from above, under a ceiling that rays of the given length reach in a cone.
ClosedFormScene openness_under_ceiling(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const double height = dice.between(0.3, 1.0), cosine = dice.between(0.2, 0.8);
  add_shape(scene, square({1.1, 0, -0.7}, {0, 1, 0}, 12.0), DiffuseBsdf{});
  add_shape(scene, square({0, height, 0}, {0, -1, 0}, 1.5 * height / cosine), DiffuseBsdf{});
  const bool even = dice.chance(0.5);
  scene.integrator.type = even ? Integrator::Type::visibility : Integrator::Type::ambient_occlusion;
  scene.integrator.length = height / cosine;
  scene.camera = look_along({0.0, 0.2 * height, 0.0}, {0, -1, 0}, kPointFov);
  move_scene(scene, dice, true);
  scene.integrator.length *= glm::length(dvec3(scene.instances[0].world_from_object[0]));
  // Directions with a greater cosine end at the ceiling.
  result.expected = even ? cosine : cosine * cosine;
  result.name = fmt::format("{} under a ceiling", even ? "av" : "ao");
  return result;
}

/// A point of a floor, a part of whose hemisphere a polygon hides: the share of it by Lambert's formula.
ClosedFormScene occlusion_by_polygon(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  double hidden = 0.0;
  while (hidden < 0.05 || hidden > 0.95) {
    scene = Scene{};
    const dvec3 d = dice.direction_around({0, 1, 0}, 0.1);
    const TriangleMesh polygon = square(dice.between(0.5, 1.0) * d, -d, dice.between(0.3, 0.9));
    hidden = polygon_irradiance(corners_of(polygon), {0, 1, 0}) / kPi;
    add_shape(scene, polygon, DiffuseBsdf{});
  }
  add_shape(scene, square({1.1, 0, -0.7}, {0, 1, 0}, 12.0), DiffuseBsdf{});
  scene.integrator.type = Integrator::Type::ambient_occlusion;
  scene.camera = look_along({0.0, 0.01, 0.0}, {0, -1, 0}, kPointFov);
  move_scene(scene, dice, true);
  result.expected = 1.0 - hidden;
  result.name = "ao beside a polygon";
  return result;
}

/// A point of a floor lit by a point, and how far it is.
ClosedFormScene lit_or_measured(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  add_shape(scene, square({0.3, 0, 0.2}, {0, 1, 0}, 3.0), DiffuseBsdf{});
  const double distance = dice.log_between(0.1, 1e5);
  scene.camera = look_along({0.0, distance, 0.0}, {0, -1, 0}, kPointFov);
  scene.camera.far_clip = 1e6;
  const bool lit = dice.chance(0.5);
  const dvec3 place = dice.between(0.3, 3.0) * dice.direction_around({0, 1, 0}, 0.1), energy = dice.color(1.0, 50.0);
  move_scene(scene, dice, false);
  const glm::dmat4& world_from_floor = scene.instances[0].world_from_object;
  const double scale = glm::length(dvec3(world_from_floor[0]));
  if (lit) {
    scene.integrator.type = Integrator::Type::simple;
    scene.integrator.light = {dvec3(world_from_floor * glm::dvec4(place, 1.0)), energy};
    const double d2 = glm::dot(place, place) * scale * scale;
    result.expected = luminance(energy) / (4.0 * kPi * kPi) * glm::normalize(place).y / d2;
  } else {
    const bool inverse = dice.chance(0.5);
    scene.integrator.type = inverse ? Integrator::Type::depth : Integrator::Type::distance;
    const double height = distance * scale;
    if (!inverse) scene.camera.near_clip = height * dice.between(0.0, 0.9);
    result.expected = inverse ? 1.0 / height : height - scene.camera.near_clip;
  }
  result.name = lit ? "floor lit by a point" : fmt::format("floor {:.2g} away", distance);
  return result;
}

/// The floor of the family direct, by several samples of each kind or as Whitted sees it.
ClosedFormScene direct_or_whitted(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result = direct_light_scene(dice, strategy);
  Integrator& integrator = result.scene.integrator;
  if (dice.chance(0.3)) {
    integrator.type = Integrator::Type::whitted;
    result.name += " as whitted";
    return result;
  }
  integrator.type = Integrator::Type::direct;
  const auto count = [&] { return static_cast<std::uint32_t>(dice.between_int(1, 4)); };
  integrator.emitter_samples = strategy == LightStrategy::naive ? 0 : count();
  integrator.bsdf_samples = strategy == LightStrategy::nee ? 0 : count();
  result.name += fmt::format(" as direct, {} and {} samples", integrator.emitter_samples, integrator.bsdf_samples);
  return result;
}

/// A mirror in an emitting box: every path ends at the box, if roulette lets it.
ClosedFormScene whitted_mirror(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 radiance = dice.color(0.2, 2.0);
  add_shape(scene, Sphere{dvec3(0.0), 0.3}, MirrorBsdf{});
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      dvec3 n(0.0);
      n[axis] = -side;
      add_shape(scene, square(-1.2 * n, n, 1.2), DiffuseBsdf{dvec3(0.0)}, radiance);
    }
  }
  scene.integrator.type = Integrator::Type::whitted;
  const dvec3 wo = dice.direction();
  scene.camera = look_along(0.7 * wo, -wo, 5.0);
  move_scene(scene, dice, true);
  result.expected = luminance(radiance);
  result.name = "whitted mirror";
  return result;
}

/// A floor below a lamp, seen through the lamp, which is hidden from the camera.
ClosedFormScene through_hidden_lamp(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 radiance = dice.color(0.2, 4.0), albedo = dice.color(0.2, 0.9);
  const Sphere lamp{{dice.between(-0.1, 0.1), dice.between(0.6, 1.0), 0.0}, dice.between(0.2, 0.4)};
  add_shape(scene, lamp, DiffuseBsdf{dvec3(0.0)}, radiance);
  add_shape(scene, square({1.1, 0, -0.7}, {0, 1, 0}, 12.0), DiffuseBsdf{albedo});
  scene.integrator.type = dice.chance(0.5) ? Integrator::Type::path : Integrator::Type::direct;
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  scene.integrator.nee = strategy != LightStrategy::naive;
  scene.integrator.mis = strategy == LightStrategy::mis;
  scene.integrator.hide_emitters = true;
  scene.camera = look_along({0.0, 3.0, 0.0}, {0, -1, 0}, kPointFov);
  move_scene(scene, dice, true);
  result.expected = luminance(albedo / kPi * sphere_irradiance(lamp.center, lamp.radius, {0, 1, 0}) * radiance);
  result.name = "floor seen through a hidden lamp";
  return result;
}

}  // namespace

ClosedFormScene integrator_scene(Dice& dice, LightStrategy strategy) {
  switch (dice.below(7)) {
    case 0:
      return openness_under_ceiling(dice);
    case 1:
      return occlusion_by_polygon(dice);
    case 2:
      return lit_or_measured(dice);
    case 3:
      return whitted_mirror(dice);
    case 4:
      return through_hidden_lamp(dice, strategy);
    default:
      return direct_or_whitted(dice, strategy);
  }
}

}  // namespace etendue::closed_form
