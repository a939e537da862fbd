/// Lights without extent: irradiance by the inverse square law [Lambert1760].

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

double radians(double degrees) {
  return degrees * kPi / 180.0;
}

/// A picture of few texels, nearest, whose values are kept apart from the bytes that renderers see.
struct Slide {
  std::uint32_t width = 1, height = 1;
  std::vector<dvec3> texels;  ///< from the upper left corner

  Slide(Dice& dice, Scene& scene)
      : width(static_cast<std::uint32_t>(dice.between_int(1, 4))),
        height(static_cast<std::uint32_t>(dice.between_int(1, 4))) {
    Bitmap bitmap{.width = width,
                  .height = height,
                  .channels = 3,
                  .format = BitmapFormat::f32,
                  .color_space = ColorSpace::linear,
                  .texels = {},
                  .notes = {}};
    for (std::uint32_t i = 0; i < width * height; ++i) {
      const glm::vec3 color(dice.color(0.1, 1.0));
      texels.emplace_back(color);
      bitmap.texels.resize(bitmap.texels.size() + sizeof color);
      std::memcpy(bitmap.texels.data() + bitmap.texels.size() - sizeof color, &color, sizeof color);
    }
    Texture texture;
    texture.source =
        BitmapTexture{.bitmap = static_cast<std::uint32_t>(scene.bitmaps.size()), .filter = TextureFilter::nearest};
    scene.bitmaps.push_back(std::make_shared<const Bitmap>(std::move(bitmap)));
    scene.textures.push_back(texture);
  }

  /// Of a place in [0, 1] from the left and from the top; nothing close to an edge of texels, where rounding decides.
  std::optional<dvec3> at(double across, double down) const {
    const double x = across * width, y = down * height;
    const auto near_edge = [](double v) { return std::abs(v - std::round(v)) < 1e-3; };
    if (near_edge(x) || near_edge(y)) return std::nullopt;
    return texels[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)];
  }
};

/// A light that sends `toward` (in its own frame, unit) to the origin from `place`.
glm::dmat4 frame_of(Dice& dice, const dvec3& place, const dvec3& toward) {
  const auto turned = [&](const dvec3& z, double angle) {
    const auto [s, t] = tangents(z);
    return glm::dmat3(std::cos(angle) * s + std::sin(angle) * t, std::cos(angle) * t - std::sin(angle) * s, z);
  };
  glm::dmat3 own = turned(toward, dice.between(0.0, 2.0 * kPi));
  if (dice.chance(0.3)) own[0] *= -1.0;  // a mirror image
  const glm::dmat3 rotation = turned(-glm::normalize(place), 0.0) * glm::transpose(own);
  glm::dmat4 frame(rotation);
  frame[3] = glm::dvec4(place, 1.0);
  return frame;
}

double spot_share(const DeltaLight& spot, double theta) {
  const double edge = radians(spot.cutoff), beam = radians(spot.beam_width);
  if (theta >= edge || theta <= beam) return theta >= edge ? 0.0 : 1.0;
  const double cosines = (std::cos(edge) - std::cos(theta)) / (std::cos(edge) - std::cos(beam));
  switch (spot.falloff) {
    case DeltaLight::Falloff::smooth:
      return cosines * cosines * (3.0 - 2.0 * cosines);
    case DeltaLight::Falloff::quartic:
      return cosines * cosines * cosines * cosines;
    case DeltaLight::Falloff::linear:
      break;
  }
  return (theta - edge) / (beam - edge);
}

/// Adds a spot at `place`; returns its intensity toward the origin.
dvec3 add_spot(Scene& scene, Dice& dice, const dvec3& place) {
  DeltaLight light{.type = DeltaLight::Type::spot, .intensity = dice.color(1.0, 6.0)};
  light.cutoff = dice.between(5.0, 80.0);
  light.beam_width = dice.between(0.0, 1.0) * light.cutoff;
  light.falloff = static_cast<DeltaLight::Falloff>(dice.below(3));
  const double theta = radians(light.cutoff) * dice.between(0.01, 1.1), phi = dice.between(0.0, 2.0 * kPi);
  const dvec3 toward(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
  dvec3 shown(1.0);
  if (theta < radians(light.cutoff) && dice.chance(0.3)) {
    const double edge = std::tan(radians(light.cutoff));
    const Slide slide(dice, scene);
    // +X is to the right and +Y down, as in Mitsuba.
    const auto texel = slide.at(0.5 + 0.5 * toward.x / toward.z / edge, 0.5 + 0.5 * toward.y / toward.z / edge);
    if (texel) {
      light.intensity.texture = static_cast<std::uint32_t>(scene.textures.size()) - 1;
      shown = *texel;
    }
  }
  light.world_from_light = frame_of(dice, place, toward);
  light.name = "spot";
  scene.delta_lights.push_back(light);
  return light.intensity.value * shown * spot_share(light, theta);
}

dvec3 add_projector(Scene& scene, Dice& dice, const dvec3& place) {
  DeltaLight light{.type = DeltaLight::Type::projector, .intensity = dice.color(1.0, 6.0)};
  light.slope = {dice.between(0.2, 1.5), dice.between(0.2, 1.5)};
  const Slide slide(dice, scene);
  light.intensity.texture = static_cast<std::uint32_t>(scene.textures.size()) - 1;
  std::optional<dvec3> texel;
  double across = 0.0, down = 0.0;
  while (!texel) {
    across = dice.between(0.0, 1.15), down = dice.between(0.0, 1.15);
    if (std::max(across, down) > 1.01) {
      texel = dvec3(0.0);  // beside the picture
    } else if (std::max(across, down) < 0.99) {
      texel = slide.at(across, down);
    }
  }
  // Like a camera: +X to the left, +Y up.
  const dvec3 toward =
      glm::normalize(dvec3((1.0 - 2.0 * across) * light.slope.x, (1.0 - 2.0 * down) * light.slope.y, 1.0));
  light.world_from_light = frame_of(dice, place, toward);
  light.name = "projector";
  scene.delta_lights.push_back(light);
  return light.intensity.value * *texel / (toward.z * toward.z * toward.z);
}

/// Adds a light of any type toward `w`; returns the irradiance it sends to a surface at the origin that faces it.
dvec3 add_light(Scene& scene, Dice& dice, const dvec3& w) {
  const dvec3 place = dice.between(0.5, 3.0) * w;
  const double d2 = glm::dot(place, place);
  switch (dice.below(4)) {
    case 0:
      return add_spot(scene, dice, place) / d2;
    case 1:
      return add_projector(scene, dice, place) / d2;
    case 2: {
      const dvec3 irradiance = dice.color(0.2, 2.0);
      scene.delta_lights.push_back({.type = DeltaLight::Type::directional,
                                    .intensity = irradiance,
                                    .world_from_light = frame_of(dice, w, {0, 0, 1}),
                                    .name = "directional"});
      return irradiance;
    }
    default:
      break;
  }
  const dvec3 intensity = dice.color(0.5, 4.0);
  DeltaLight light{.intensity = intensity, .name = "point"};
  light.world_from_light[3] = glm::dvec4(place, 1.0);
  scene.delta_lights.push_back(light);
  return intensity / d2;
}

/// A body that hides only the light toward `w`: none of the others is within its cone.
void hide(Scene& scene, const dvec3& w) {
  add_shape(scene, Sphere{0.25 * w, 0.02}, DiffuseBsdf{dvec3(0.0)});
}

bool apart(const std::vector<dvec3>& directions, const dvec3& w, double angle) {
  return std::ranges::all_of(directions, [&](const dvec3& other) { return glm::dot(other, w) < std::cos(angle); });
}

}  // namespace

ClosedFormScene delta_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 n(0, 1, 0), albedo = dice.color(0.2, 0.9);
  // Emitters that material samples can also find: a lamp, and a sky that it partly hides.
  const dvec3 lamp_axis = dice.direction_around(n, 0.3);
  const bool has_lamp = dice.chance(0.5), has_sky = dice.chance(0.4);
  constexpr double kLampAngle = 0.3;
  dvec3 irradiance(0.0);
  if (has_lamp) {
    const Sphere lamp{1.5 * lamp_axis, 1.5 * std::sin(kLampAngle)};
    const dvec3 radiance = dice.color(0.2, 4.0);
    add_shape(scene, lamp, DiffuseBsdf{dvec3(0.0)}, radiance);
    irradiance += radiance * sphere_irradiance(lamp.center, lamp.radius, n);
  }
  if (has_sky) {
    scene.sky.top = scene.sky.horizon = dice.color(0.1, 1.0);
    const double hidden = has_lamp ? sphere_irradiance(1.5 * lamp_axis, 1.5 * std::sin(kLampAngle), n) : 0.0;
    irradiance += scene.sky.top * (kPi - hidden);
  }
  const bool many = dice.chance(0.3);
  const int count = many ? dice.between_int(10, 20) : dice.between_int(1, 5);
  std::vector<dvec3> directions;
  if (has_lamp) directions.push_back(lamp_axis);
  int hidden = 0;
  for (int i = 0; i < count; ++i) {
    dvec3 w = dice.direction();
    const double room = directions.empty() ? 0.0 : 0.2;
    while (w.y < -0.5 || !apart(directions, w, room) || (has_lamp && glm::dot(w, lamp_axis) > std::cos(0.5)))
      w = dice.direction();
    directions.push_back(w);
    const dvec3 facing = add_light(scene, dice, w);
    // A sky would shine around the body.
    const bool blocked = !has_sky && dice.chance(0.2);
    if (blocked) hide(scene, w);
    hidden += blocked ? 1 : 0;
    if (!blocked && strategy != LightStrategy::naive) irradiance += facing * std::max(0.0, w.y);
  }
  add_shape(scene, square({1.1, 0, -0.7}, n, 12.0), DiffuseBsdf{albedo});
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  set_strategy(scene, strategy);
  const bool direct = dice.chance(0.3);
  if (direct) {
    scene.integrator.type = Integrator::Type::direct;
    scene.integrator.emitter_samples = strategy == LightStrategy::naive ? 0 : 2;
    scene.integrator.bsdf_samples = strategy == LightStrategy::nee ? 0 : 1;
  }
  scene.camera = look_along({0, 0.01, 0}, {0, -1, 0}, kPointFov);
  move_scene(scene, dice, true);
  result.expected = luminance(albedo / kPi * irradiance);
  const auto of_type = [&](DeltaLight::Type type) {
    return std::ranges::count(scene.delta_lights, type, &DeltaLight::type);
  };
  using Type = DeltaLight::Type;
  result.name = fmt::format("points, {} point(s), {} spot(s), {} projector(s), {} directional, {} hidden{}{}{}, {}",
                            of_type(Type::point), of_type(Type::spot), of_type(Type::projector),
                            of_type(Type::directional), hidden, has_lamp ? ", a lamp" : "", has_sky ? ", a sky" : "",
                            direct ? ", as direct" : "", light_strategy_name(strategy));
  return result;
}

}  // namespace etendue::closed_form
