/// Stacks of adapters around diffuse materials: a floor under a lamp, seen from either side of its normal, with veils
/// between it and the lamp and a shining ground behind it.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

constexpr double kHalf = 3.0;  // half width of the floor: texture coordinates run from 0 to 1 over it

/// A row of the table and what it is called.
struct Stack {
  std::uint32_t row = 0;
  std::string name;
};

std::uint32_t add_row(Scene& scene, Material material) {
  scene.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

/// A texture that is the same everywhere.
std::uint32_t add_constant(Scene& scene, const dvec3& color) {
  scene.textures.push_back({.source = CheckerboardTexture{color, color}, .name = "checkerboard"});
  return static_cast<std::uint32_t>(scene.textures.size() - 1);
}

/// A probability, constant or as a channel of a texture.
ScalarParameter probability(Dice& dice, Scene& scene, double value) {
  if (dice.chance(0.5)) return value;
  const auto channel = static_cast<TextureChannel>(dice.below(3));
  dvec3 color = dice.color(0.0, 1.0);
  color[static_cast<int>(channel)] = dice.between(0.5, 1.0);
  const double factor = value / color[static_cast<int>(channel)];
  if (factor > 1.0) return value;
  return {factor, add_constant(scene, color), channel};
}

/// Up to 25° away from the normal, as a colour.
dvec3 normal_color(Dice& dice) {
  return 0.5 + 0.5 * dice.direction_around({0, 0, 1}, 0.9);
}

/// Four texels between whose centres heights grow evenly.
std::uint32_t add_slope(Dice& dice, Scene& scene) {
  const float a = static_cast<float>(dice.between(-1.0, 1.0)), b = static_cast<float>(dice.between(-1.0, 1.0));
  const float rows[4] = {b, a + b, 0.0f, a};
  auto bitmap = std::make_shared<Bitmap>();
  bitmap->width = bitmap->height = 2;
  bitmap->channels = 1;
  bitmap->format = BitmapFormat::f32;
  bitmap->texels.resize(sizeof rows);
  std::memcpy(bitmap->texels.data(), rows, sizeof rows);
  scene.bitmaps.push_back(std::move(bitmap));
  scene.textures.push_back(
      {.source = BitmapTexture{static_cast<std::uint32_t>(scene.bitmaps.size() - 1)}, .name = "slope"});
  return static_cast<std::uint32_t>(scene.textures.size() - 1);
}

Stack random_stack(Dice& dice, Scene& scene, int depth, bool may_pass, bool black) {
  if (depth == 0) {
    const dvec3 albedo = black ? dvec3(0.0) : dice.color(0.1, 0.9);
    return {add_row(scene, {.bsdf = DiffuseBsdf{albedo}, .name = "diffuse"}), "d"};
  }
  const int kind = dice.below(may_pass ? 6 : 4);
  if (kind == 5) return {add_row(scene, {.bsdf = NullBsdf{}, .name = "null"}), "n"};
  const Stack a = random_stack(dice, scene, depth - 1, may_pass && kind != 0, black);
  if (kind == 0) {
    const Stack back = random_stack(dice, scene, depth - 1, false, black);
    return {add_row(scene, {.adapter = TwoSidedAdapter{a.row, back.row}, .name = "twosided"}),
            fmt::format("t({}{})", a.name, back.name)};
  }
  if (kind == 1) {
    const Stack b = random_stack(dice, scene, depth - 1, may_pass, black);
    const ScalarParameter weight = probability(dice, scene, dice.between(0.0, 1.0));
    return {add_row(scene, {.adapter = BlendAdapter{weight, a.row, b.row}, .name = "blend"}),
            fmt::format("b({}{})", a.name, b.name)};
  }
  if (kind == 2)
    return {add_row(scene, {.adapter = NormalMapAdapter{{dvec3(1.0), add_constant(scene, normal_color(dice))}, a.row},
                            .name = "normalmap"}),
            fmt::format("o({})", a.name)};
  if (kind == 3)
    return {add_row(scene, {.adapter =
                                BumpMapAdapter{
                                    {dice.between(0.2, 1.0), add_slope(dice, scene), TextureChannel::luminance}, a.row},
                            .name = "bumpmap"}),
            fmt::format("u({})", a.name)};
  const ScalarParameter opacity = probability(dice, scene, dice.between(0.2, 1.0));
  return {add_row(scene, {.adapter = MaskAdapter{opacity, a.row}, .name = "mask"}), fmt::format("m({})", a.name)};
}

/// A constant probability, whatever it is made of.
double value_of(const Scene& scene, const ScalarParameter& parameter) {
  if (!parameter.texture) return parameter.value;
  return parameter.value * std::get<CheckerboardTexture>(scene.textures[*parameter.texture].source)
                               .color0[static_cast<int>(parameter.channel)];
}

/// The irradiance that a map leaves of a square lamp, seen from the origin, where it has turned the normal `base` to
/// `n`: by quadrature over the lamp, as no polygon formula knows of the shadows.
double turned_irradiance(std::span<const dvec3> lamp, const dvec3& n, const dvec3& base) {
  constexpr int kSteps = 64;  // along each side: four digits
  const dvec3 a = lamp[1] - lamp[0], b = lamp[3] - lamp[0], cross = glm::cross(a, b);
  const auto tan2 = [](double cosine) { return std::max(0.0, 1.0 / (cosine * cosine) - 1.0); };
  const double slope2 = tan2(glm::dot(n, base));
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const dvec3 p = lamp[0] + (i + 0.5) / kSteps * a + (j + 0.5) / kSteps * b;
      const double d2 = glm::dot(p, p);
      const dvec3 w = p / std::sqrt(d2);
      const double across = glm::dot(w, base), cosine = glm::dot(w, n);
      if (!(across > 0.0 && cosine > 0.0)) continue;
      const double share = 2.0 / (1.0 + std::sqrt(1.0 + std::min(slope2 / 8.0, 1.0) * tan2(across)));
      sum += cosine * share * std::abs(glm::dot(cross, w)) / d2;
    }
  }
  return sum / (kSteps * kSteps);
}

/// The mean effect of a stack on light, at the middle of a square with the tangents `s` and `t`, seen from `wo`.
struct Mean {
  const Scene& scene;
  const dvec3 s, t, wo;
  std::span<const dvec3> lamp;
  dvec3 reflected{0.0};  ///< irradiance of the lamp times albedo over π
  double pass = 0.0;

  void add(std::uint32_t row, double weight, const dvec3& n, double side, const dvec3& base) {
    const Material& material = scene.materials[row];
    if (!material.adapter) {
      if (std::holds_alternative<NullBsdf>(material.bsdf)) {
        pass += weight;
      } else if (glm::dot(wo, n) > 0.0 && glm::dot(wo, base) > 0.0) {
        const double arrives = n == base ? polygon_irradiance(lamp, n) : turned_irradiance(lamp, n, base);
        reflected += weight / kPi * std::get<DiffuseBsdf>(material.bsdf).albedo.value * arrives;
      }
      return;
    }
    std::visit([&](const auto& adapter) { add_adapter(adapter, weight, n, side, base); }, *material.adapter);
  }

 private:
  void add_adapter(const TwoSidedAdapter& a, double weight, const dvec3& n, double side, const dvec3& base) {
    if (glm::dot(wo, n) < 0.0)
      add(a.back, weight, -n, -side, -base);
    else
      add(a.front, weight, n, side, base);
  }
  void add_adapter(const MaskAdapter& mask, double weight, const dvec3& n, double side, const dvec3& base) {
    const double opacity = value_of(scene, mask.opacity);
    pass += weight * (1.0 - opacity);
    add(mask.inner, weight * opacity, n, side, base);
  }
  void add_adapter(const BlendAdapter& blend, double weight, const dvec3& n, double side, const dvec3& base) {
    const double second = value_of(scene, blend.weight);
    add(blend.first, weight * (1.0 - second), n, side, base);
    add(blend.second, weight * second, n, side, base);
  }
  void add_adapter(const NormalMapAdapter& map, double weight, const dvec3& n, double side, const dvec3& base) {
    const dvec3 c = 2.0 * std::get<CheckerboardTexture>(scene.textures[*map.normals.texture].source).color0 - 1.0;
    const dvec3 along = glm::normalize(s - n * glm::dot(n, s));
    const dvec3 turned = c.x * along + c.y * side * glm::cross(n, along) + c.z * n;
    add(map.inner, weight, glm::normalize(turned), side, base);
  }
  void add_adapter(const BumpMapAdapter& map, double weight, const dvec3& n, double side, const dvec3& base) {
    const Texture& texture = scene.textures[*map.height.texture];
    float rows[4];
    std::memcpy(rows, scene.bitmaps[std::get<BitmapTexture>(texture.source).bitmap]->texels.data(), sizeof rows);
    const double by_u = map.height.value * static_cast<double>(rows[3] - rows[2]) * 2.0;
    const double by_v = map.height.value * static_cast<double>(rows[0] - rows[2]) * 2.0;
    const dvec3 u = 2.0 * kHalf * s, v = 2.0 * kHalf * t;
    const dvec3 m = glm::cross(u + n * (by_u - glm::dot(n, u)), v + n * (by_v - glm::dot(n, v)));
    add(map.inner, weight, glm::normalize(glm::dot(m, n) < 0.0 ? -m : m), side, base);
  }
};

void add_of(Scene& scene, Shape shape, std::uint32_t material, const char* name) {
  if (auto* mesh = std::get_if<TriangleMesh>(&shape)) mesh->uv_sets.push_back({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  scene.instances.push_back(
      {.shape = static_cast<std::uint32_t>(scene.shapes.size()), .material = material, .name = name});
  scene.shapes.push_back(std::move(shape));
}

/// Heights are those of the world, which is larger or smaller now.
void scale_heights(Scene& scene) {
  const double scale = glm::length(dvec3(scene.instances[0].world_from_object[0]));
  for (Material& material : scene.materials) {
    if (!material.adapter) continue;
    if (auto* map = std::get_if<BumpMapAdapter>(&*material.adapter)) map->height.value *= scale;
  }
}

ClosedFormScene seen_floor(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 up(0, 1, 0);
  const TriangleMesh lamp =
      square({dice.between(-0.3, 0.3), 1.0, dice.between(-0.3, 0.3)}, -up, dice.between(0.1, 0.4));
  const dvec3 radiance = dice.color(1.0, 4.0), ground = dice.color(0.05, 0.3);
  const Stack floor = random_stack(dice, scene, dice.between_int(0, 4), true, false);
  const Stack veil = random_stack(dice, scene, dice.between_int(0, 3), true, true);
  const bool front = dice.chance(0.7), ball = dice.chance(0.5);
  const dvec3 n = front ? up : -up;
  add_of(scene, square(dvec3(0.0), n, kHalf), floor.row, "floor");
  if (ball)
    add_of(scene, Sphere{{0, 0.5, 0}, 0.42}, veil.row, "veil");
  else
    add_of(scene, square({0, 0.5, 0}, dice.chance(0.5) ? up : -up, kHalf), veil.row, "veil");
  add_shape(scene, lamp, DiffuseBsdf{dvec3(0.0)}, radiance);
  add_shape(scene, square({0, -1, 0}, up, kHalf), DiffuseBsdf{dvec3(0.0)}, ground);
  set_strategy(scene, strategy);
  scene.integrator.rr_depth = 0;
  scene.integrator.count_passes = dice.chance(0.7);
  const bool deep = dice.chance(0.8);
  scene.integrator.max_depth = deep ? 4 : 2;
  const bool arrives = deep || !scene.integrator.count_passes;
  // From just above the floor; a ball is large enough to hide the whole lamp, and its veil is crossed twice.
  scene.camera = look_along({0, 0.01, 0}, -up, kPointFov);
  const auto [s, t] = tangents(n);
  const std::vector<dvec3> corners = corners_of(lamp);
  Mean seen{scene, s, t, up, corners}, between{scene, s, t, up, corners};
  seen.add(floor.row, 1.0, n, 1.0, n);
  between.add(veil.row, 1.0, n, 1.0, n);
  const double veiled = between.pass > 0.0 && arrives ? std::pow(between.pass, ball ? 2 : 1) : 0.0;
  result.expected = luminance(seen.pass * ground + veiled * radiance * seen.reflected);
  move_scene(scene, dice, true);
  scale_heights(scene);
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
