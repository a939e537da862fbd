/// Stacks of adapters around diffuse materials: a floor under a lamp, seen from either side of its normal, with veils
/// between it and the lamp and a shining ground behind it.

#include <string>

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

/// A row of the table, and what it does on the mean: to light that is reflected, on either side of the normal, and to
/// light that passes.
struct Stack {
  std::uint32_t row = 0;
  dvec3 front{0.0}, back{0.0};
  double pass = 0.0;
  std::string name;
};

std::uint32_t add_row(Scene& scene, Material material) {
  scene.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

Stack diffuse(Dice& dice, Scene& scene, bool black) {
  const dvec3 albedo = black ? dvec3(0.0) : dice.color(0.1, 0.9);
  return {.row = add_row(scene, {.bsdf = DiffuseBsdf{albedo}, .name = "diffuse"}), .front = albedo, .name = "d"};
}

/// The stack's probability, constant or from a texture with as many squares of each colour at every place that counts:
/// both squares have the same channel in question.
ScalarParameter probability(Dice& dice, Scene& scene, double value) {
  if (dice.chance(0.5)) return value;
  const auto channel = static_cast<TextureChannel>(dice.below(3));
  dvec3 color = dice.color(0.0, 1.0);
  color[static_cast<int>(channel)] = dice.between(0.5, 1.0);
  const double factor = value / color[static_cast<int>(channel)];
  if (factor > 1.0) return value;
  scene.textures.push_back({.source = CheckerboardTexture{color, color}, .name = "checkerboard"});
  return {factor, static_cast<std::uint32_t>(scene.textures.size() - 1), channel};
}

Stack random_stack(Dice& dice, Scene& scene, int depth, bool may_pass, bool black) {
  const int kind = depth == 0 ? 0 : dice.below(may_pass ? 5 : 3);
  switch (kind) {
    case 1: {
      const Stack front = random_stack(dice, scene, depth - 1, false, black);
      const Stack back = random_stack(dice, scene, depth - 1, false, black);
      const std::uint32_t row = add_row(scene, {.adapter = TwoSidedAdapter{front.row, back.row}, .name = "twosided"});
      return {row, front.front, back.front, 0.0, fmt::format("t({}{})", front.name, back.name)};
    }
    case 2: {
      const Stack a = random_stack(dice, scene, depth - 1, may_pass, black);
      const Stack b = random_stack(dice, scene, depth - 1, may_pass, black);
      const double w = dice.between(0.0, 1.0);
      const std::uint32_t row =
          add_row(scene, {.adapter = BlendAdapter{probability(dice, scene, w), a.row, b.row}, .name = "blend"});
      return {row, glm::mix(a.front, b.front, w), glm::mix(a.back, b.back, w), glm::mix(a.pass, b.pass, w),
              fmt::format("b({}{})", a.name, b.name)};
    }
    case 3: {
      const Stack inner = random_stack(dice, scene, depth - 1, true, black);
      const double o = dice.between(0.2, 1.0);
      const std::uint32_t row =
          add_row(scene, {.adapter = MaskAdapter{probability(dice, scene, o), inner.row}, .name = "mask"});
      return {row, o * inner.front, o * inner.back, 1.0 - o + o * inner.pass, fmt::format("m({})", inner.name)};
    }
    case 4:
      return {.row = add_row(scene, {.bsdf = NullBsdf{}, .name = "null"}), .pass = 1.0, .name = "n"};
    default:
      return diffuse(dice, scene, black);
  }
}

void add_of(Scene& scene, Shape shape, std::uint32_t material, const char* name) {
  if (auto* mesh = std::get_if<TriangleMesh>(&shape))
    mesh->uv_sets.emplace_back(mesh->positions.size(), glm::vec2(0.3f, 0.4f));
  scene.instances.push_back(
      {.shape = static_cast<std::uint32_t>(scene.shapes.size()), .material = material, .name = name});
  scene.shapes.push_back(std::move(shape));
}

ClosedFormScene seen_floor(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 up(0, 1, 0);
  const TriangleMesh lamp =
      square({dice.between(-0.3, 0.3), 1.0, dice.between(-0.3, 0.3)}, -up, dice.between(0.1, 0.4));
  const dvec3 radiance = dice.color(1.0, 4.0), ground = dice.color(0.05, 0.3);
  const Stack floor = random_stack(dice, scene, dice.between_int(1, 4), true, false);
  const Stack veil = random_stack(dice, scene, dice.between_int(0, 3), true, true);
  const bool front = dice.chance(0.7), ball = dice.chance(0.5);
  const int crossings = ball ? 2 : 1;
  add_of(scene, square(dvec3(0.0), front ? up : -up, 3.0), floor.row, "floor");
  if (ball)
    add_of(scene, Sphere{{0, 0.5, 0}, 0.42}, veil.row, "veil");
  else
    add_of(scene, square({0, 0.5, 0}, dice.chance(0.5) ? up : -up, 3.0), veil.row, "veil");
  add_shape(scene, lamp, DiffuseBsdf{dvec3(0.0)}, radiance);
  add_shape(scene, square({0, -1, 0}, up, 3.0), DiffuseBsdf{dvec3(0.0)}, ground);
  set_strategy(scene, strategy);
  scene.integrator.rr_depth = 0;
  scene.integrator.count_passes = dice.chance(0.7);
  const bool deep = dice.chance(0.8);
  scene.integrator.max_depth = deep ? 4 : 2;
  const bool arrives = deep || !scene.integrator.count_passes;
  // From just above the floor; a ball is large enough to hide the whole lamp, and its veil is crossed twice.
  scene.camera = look_along({0, 0.01, 0}, -up, kPointFov);
  const dvec3 irradiance = polygon_irradiance(lamp.positions, up) * radiance;
  const dvec3 reflected = (front ? floor.front : floor.back) * irradiance / kPi;
  result.expected = luminance(floor.pass * ground + (arrives ? std::pow(veil.pass, crossings) : 0.0) * reflected);
  move_scene(scene, dice, true);
  result.name = fmt::format("adapters, floor {} from {}, {} {}, {}{}, {}", floor.name, front ? "the front" : "behind",
                            ball ? "ball" : "veil", veil.name, deep ? "deep" : "shallow",
                            scene.integrator.count_passes ? "" : " without count", light_strategy_name(strategy));
  return result;
}

}  // namespace

ClosedFormScene adapter_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result = seen_floor(dice, strategy);
  while (result.expected < 1e-3) result = seen_floor(dice, strategy);
  return result;
}

}  // namespace etendue::closed_form
