/// Light from outside: irradiance by quadrature.

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

/// A picture with its radiance kept apart from the bytes that renderers see.
struct Picture {
  SkyPicture sky;
  std::uint32_t width = 1, height = 1;
  std::vector<dvec3> radiance;  ///< row by row from the top

  dvec3 texel(std::int64_t x, std::int64_t y) const {
    const std::int64_t column = (x % width + width) % width, row = std::clamp<std::int64_t>(y, 0, height - 1);
    return radiance[static_cast<std::size_t>(row * width + column)];
  }
  /// The radiance from a direction in the sky's frame.
  dvec3 at(const dvec3& d) const {
    const double u = std::atan2(d.x, -d.z) / (2.0 * kPi), v = std::acos(std::clamp(d.y, -1.0, 1.0)) / kPi;
    const double x = u * width - 0.5;
    const double y = sky.rows == SkyPicture::Rows::bands ? v * height - 0.5 : v * (height - 1.0);
    const auto left = static_cast<std::int64_t>(std::floor(x)), top = static_cast<std::int64_t>(std::floor(y));
    const double a = x - static_cast<double>(left), b = y - static_cast<double>(top);
    return (1 - b) * ((1 - a) * texel(left, top) + a * texel(left + 1, top)) +
           b * ((1 - a) * texel(left, top + 1) + a * texel(left + 1, top + 1));
  }
};

/// 8-bit codes of sRGB or floats; a third of the texels is black.
Picture random_picture(Dice& dice) {
  Picture picture;
  picture.width = static_cast<std::uint32_t>(dice.between_int(1, 9));
  picture.height = static_cast<std::uint32_t>(dice.between_int(1, 7));
  picture.sky.rows = dice.chance(0.5) ? SkyPicture::Rows::bands : SkyPicture::Rows::circles;
  picture.sky.scale = dice.log_between(0.2, 5.0);
  const bool codes = dice.chance(0.4), grey = dice.chance(0.3);
  Bitmap bitmap{.width = picture.width,
                .height = picture.height,
                .channels = grey ? 1u : 3u,
                .format = codes ? BitmapFormat::u8 : BitmapFormat::f32,
                .color_space = codes ? ColorSpace::srgb : ColorSpace::linear,
                .texels = {},
                .notes = {}};
  for (std::uint32_t i = 0; i < picture.width * picture.height; ++i) {
    const bool black = i > 0 && dice.chance(0.33);
    dvec3 color(0.0);
    for (std::uint32_t c = 0; c < bitmap.channels; ++c) {
      if (codes) {
        const int code = black ? 0 : dice.between_int(30, 255);
        const double x = code / 255.0;
        bitmap.texels.push_back(static_cast<std::byte>(code));
        color[static_cast<int>(c)] = x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
      } else {
        const auto value = black ? 0.0f : static_cast<float>(dice.log_between(0.05, 5.0));
        bitmap.texels.resize(bitmap.texels.size() + sizeof value);
        std::memcpy(bitmap.texels.data() + bitmap.texels.size() - sizeof value, &value, sizeof value);
        color[static_cast<int>(c)] = value;
      }
    }
    picture.radiance.push_back(picture.sky.scale * (grey ? dvec3(color.x) : color));
  }
  picture.sky.bitmap = std::make_shared<const Bitmap>(std::move(bitmap));
  return picture;
}

/// ∫ picture(ω) max(0, ω·n) dω, all in the sky's frame.
dvec3 irradiance(const Picture& picture, const dvec3& n) {
  // Kinks lie where cells end, so each has a whole number of steps.
  const auto steps = [](std::uint32_t multiple, std::uint32_t least) {
    return static_cast<int>((least / multiple + 1) * multiple);
  };
  const int columns = steps(2 * picture.width, 600);
  const int rows = steps(2 * picture.height * std::max(picture.height - 1, 1u), 800);
  dvec3 sum(0.0);
  for (int j = 0; j < rows; ++j) {
    const double theta = kPi * (j + 0.5) / rows, y = std::cos(theta), r = std::sin(theta);
    dvec3 row(0.0);
    for (int i = 0; i < columns; ++i) {
      const double phi = 2.0 * kPi * (i + 0.5) / columns;
      const dvec3 d(r * std::cos(phi), y, r * std::sin(phi));
      const double cosine = glm::dot(d, n);
      if (cosine > 0.0) row += cosine * picture.at(d);
    }
    sum += r * row;
  }
  return sum * (kPi / rows * 2.0 * kPi / columns);
}

/// The part of it that a sphere hides.
dvec3 hidden_irradiance(const Picture& picture, const dvec3& n, const Sphere& sphere) {
  constexpr int kRings = 200, kSectors = 400;
  const double distance = glm::length(sphere.center), sine = sphere.radius / distance;
  const double height = 1.0 - std::sqrt(1.0 - sine * sine);  // of the cap of directions
  const dvec3 axis = sphere.center / distance;
  const auto [s, t] = tangents(axis);
  dvec3 sum(0.0);
  for (int j = 0; j < kRings; ++j) {
    const double z = 1.0 - height * (j + 0.5) / kRings, r = std::sqrt(1.0 - z * z);
    for (int i = 0; i < kSectors; ++i) {
      const double phi = 2.0 * kPi * (i + 0.5) / kSectors;
      const dvec3 d = z * axis + r * (std::cos(phi) * s + std::sin(phi) * t);
      sum += std::max(0.0, glm::dot(d, n)) * picture.at(d);
    }
  }
  return sum * (2.0 * kPi * height / (kRings * kSectors));
}

}  // namespace

ClosedFormScene environment_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const Picture picture = random_picture(dice);
  scene.sky.picture = picture.sky;
  const dvec3 n = dice.direction(), wo = dice.direction_around(n, 0.3), albedo = dice.color(0.2, 0.9);
  dvec3 light = irradiance(picture, n);
  add_shape(scene, square(dvec3(0.0), n, 1.0), DiffuseBsdf{albedo});
  const bool lamp = dice.chance(0.5);
  if (lamp) {
    const Sphere sphere{dice.between(1.5, 3.0) * dice.direction_around(n, 0.2), dice.between(0.2, 0.6)};
    const dvec3 radiance = dice.color(0.5, 8.0);
    light += sphere_irradiance(sphere.center, sphere.radius, n) * radiance - hidden_irradiance(picture, n, sphere);
    add_shape(scene, sphere, DiffuseBsdf{dvec3(0.0)}, radiance);
  }
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  set_strategy(scene, strategy);
  scene.camera = look_along(0.01 * wo, -wo, kPointFov);
  // So far everything is in the sky's frame. The world may be its mirror image.
  if (dice.chance(0.3)) {
    glm::dmat4 mirror(1.0);
    mirror[0][0] = -1.0;
    for (Instance& instance : scene.instances) instance.world_from_object = mirror * instance.world_from_object;
    scene.camera.world_from_camera = mirror * scene.camera.world_from_camera;
    scene.sky.world_from_sky = 3.0 * glm::dmat3(mirror);  // the scale is of no account
  }
  move_scene(scene, dice, true);
  result.expected = luminance(albedo / kPi * light);
  result.name = fmt::format("picture sky of {}x{}, {}{}, {}", picture.width, picture.height,
                            picture.sky.rows == SkyPicture::Rows::bands ? "bands" : "circles",
                            lamp ? ", with a lamp" : "", light_strategy_name(strategy));
  return result;
}

}  // namespace etendue::closed_form
