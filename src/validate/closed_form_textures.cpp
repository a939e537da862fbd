/// A textured floor under a textured lamp: irradiance by quadrature, textures by a third program of their own.

#include <algorithm>
#include <cstring>
#include <memory>

#include <fmt/format.h>

#include "validate/closed_form_dice.h"

namespace etendue::closed_form {
namespace {

using glm::dvec2;

const char* wrap_name(TextureWrap wrap) {
  return wrap == TextureWrap::repeat ? "repeat" : wrap == TextureWrap::mirror ? "mirror" : "clamp";
}

/// A small picture without symmetries, and what is known of it here: light, by column and row.
struct TexturePicture {
  std::shared_ptr<Bitmap> bitmap = std::make_shared<Bitmap>();
  std::vector<dvec3> light;

  explicit TexturePicture(Dice& dice) {
    Bitmap& b = *bitmap;
    b.width = static_cast<std::uint32_t>(dice.between_int(2, 5));
    b.height = static_cast<std::uint32_t>(dice.between_int(2, 5));
    b.channels = static_cast<std::uint32_t>(dice.between_int(1, 4));
    b.format = dice.chance(0.6) ? BitmapFormat::u8 : BitmapFormat::f32;
    b.color_space = b.format == BitmapFormat::u8 && dice.chance(0.7) ? ColorSpace::srgb : ColorSpace::linear;
    for (std::uint32_t i = 0; i < b.width * b.height; ++i) {
      std::vector<double> numbers;
      for (std::uint32_t c = 0; c < b.channels; ++c) numbers.push_back(add_number(dice));
      const bool color = b.channels > 2;
      light.push_back(color ? dvec3(numbers[0], numbers[1], numbers[2]) : dvec3(numbers[0]));
    }
  }
  /// Light at a place in texels, (0,0) being the upper left corner of the first texel.
  dvec3 at(double column, double row, const BitmapTexture& how) const {
    return light[index(row, bitmap->height, how.wrap_v) * bitmap->width + index(column, bitmap->width, how.wrap_u)];
  }

 private:
  /// Appends a number to the bitmap and returns its light.
  double add_number(Dice& dice) {
    if (bitmap->format == BitmapFormat::f32) {
      const auto value = static_cast<float>(dice.between(0.0, 1.5));
      std::byte bytes[sizeof value];
      std::memcpy(bytes, &value, sizeof value);
      bitmap->texels.insert(bitmap->texels.end(), bytes, bytes + sizeof value);
      return static_cast<double>(value);
    }
    const int code = dice.between_int(0, 255);
    bitmap->texels.push_back(static_cast<std::byte>(code));
    const double v = code / 255.0;
    if (bitmap->color_space == ColorSpace::linear) return v;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  }
  static std::size_t index(double place, std::uint32_t count, TextureWrap wrap) {
    const auto n = static_cast<std::int64_t>(count);
    auto i = static_cast<std::int64_t>(std::floor(place));
    if (wrap == TextureWrap::clamp) return static_cast<std::size_t>(std::clamp<std::int64_t>(i, 0, n - 1));
    const std::int64_t period = wrap == TextureWrap::mirror ? 2 * n : n;
    i = (i % period + period) % period;
    return static_cast<std::size_t>(i < n ? i : 2 * n - 1 - i);
  }
};

/// A texture of the scene, with its closed form.
struct Pattern {
  Texture texture;
  std::optional<TexturePicture> picture;
  std::string name;

  Pattern(Dice& dice, Scene& scene) {
    const double angle = dice.between(0.0, 2.0 * kPi), su = dice.between(0.3, 1.2), sv = dice.between(-1.2, -0.3);
    texture.uv_transform = glm::dmat3(su * std::cos(angle), sv * std::sin(angle), 0.0,   //
                                      -su * std::sin(angle), sv * std::cos(angle), 0.0,  //
                                      dice.between(-2.0, 2.0), dice.between(-2.0, 2.0), 1.0);
    if (dice.chance(0.2)) {
      texture.source = CheckerboardTexture{dice.color(0.0, 1.0), dice.color(0.0, 1.0)};
      name = "checkerboard";
      return;
    }
    picture.emplace(dice);
    BitmapTexture source{.bitmap = static_cast<std::uint32_t>(scene.bitmaps.size())};
    source.wrap_u = static_cast<TextureWrap>(dice.below(3));
    source.wrap_v = static_cast<TextureWrap>(dice.below(3));
    source.filter = dice.chance(0.5) ? TextureFilter::bilinear : TextureFilter::nearest;
    scene.bitmaps.push_back(picture->bitmap);
    texture.source = source;
    const bool srgb = picture->bitmap->color_space == ColorSpace::srgb;
    name = fmt::format("{} {} {}{}", source.filter == TextureFilter::bilinear ? "bilinear" : "nearest",
                       wrap_name(source.wrap_u), wrap_name(source.wrap_v), srgb ? " sRGB" : "");
  }

  dvec3 value(const dvec2& surface_uv) const {
    const glm::dmat3& m = texture.uv_transform;
    const double u = m[0][0] * surface_uv.x + m[1][0] * surface_uv.y + m[2][0];
    const double v = m[0][1] * surface_uv.x + m[1][1] * surface_uv.y + m[2][1];
    if (const auto* board = std::get_if<CheckerboardTexture>(&texture.source)) {
      const auto cell = static_cast<std::int64_t>(std::floor(2.0 * u)) + static_cast<std::int64_t>(std::floor(2.0 * v));
      return cell % 2 == 0 ? board->color0 : board->color1;
    }
    const auto& how = std::get<BitmapTexture>(texture.source);
    const double x = u * picture->bitmap->width, y = (1.0 - v) * picture->bitmap->height;
    if (how.filter == TextureFilter::nearest) return picture->at(x, y, how);
    dvec3 sum(0.0);  // a texel counts as a tent around its centre
    for (const double column : {std::floor(x - 0.5), std::floor(x + 0.5)}) {
      for (const double row : {std::floor(y - 0.5), std::floor(y + 0.5)})
        sum += (1.0 - std::abs(column + 0.5 - x)) * (1.0 - std::abs(row + 0.5 - y)) * picture->at(column, row, how);
    }
    return sum;
  }
};

/// A parallelogram with texture coordinates: corner + s a + t b has uv + (s, t).
struct Patch {
  dvec3 corner, a, b;
  dvec2 uv;

  TriangleMesh mesh() const {
    TriangleMesh mesh = polygon_mesh({corner, corner + a, corner + a + b, corner + b});
    std::vector<glm::vec2> uvs;
    for (const dvec2& st : {dvec2(0, 0), dvec2(1, 0), dvec2(1, 1), dvec2(0, 1)}) uvs.emplace_back(uv + st);
    mesh.uv_sets.push_back(std::move(uvs));
    return mesh;
  }
};

/// Irradiance at the origin, normal +y, of a lamp: midpoints of squares so small that the edges of texels between them
/// do not show.
dvec3 patch_irradiance(const Patch& lamp, const Pattern& pattern) {
  constexpr int kSteps = 384;
  const dvec3 area = glm::cross(lamp.a, lamp.b);  // toward the side that shines
  dvec3 sum(0.0);
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const dvec2 st((i + 0.5) / kSteps, (j + 0.5) / kSteps);
      const dvec3 p = lamp.corner + st.x * lamp.a + st.y * lamp.b;
      const double d2 = glm::dot(p, p), toward = -glm::dot(p, area), above = p.y;
      if (toward > 0.0 && above > 0.0) sum += pattern.value(lamp.uv + st) * (toward * above / (d2 * d2));
    }
  }
  return sum / static_cast<double>(kSteps) / static_cast<double>(kSteps);
}

}  // namespace

ClosedFormScene texture_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const Pattern lamp_pattern(dice, scene), floor_pattern(dice, scene);
  scene.textures = {lamp_pattern.texture, floor_pattern.texture};
  // Above the origin, facing down: x × z is −y.
  const Patch lamp{{dice.between(-1.5, -0.5), dice.between(0.5, 1.2), dice.between(-1.5, -0.5)},
                   {dice.between(1.0, 2.5), 0.0, dice.between(-0.3, 0.3)},
                   {dice.between(-0.3, 0.3), dice.between(0.0, 0.3), dice.between(1.0, 2.5)},
                   {dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)}};
  const dvec3 factor = dice.color(0.5, 4.0), albedo = dice.color(0.3, 0.9);
  scene.add(lamp.mesh(), DiffuseBsdf{dvec3(0.0)}, AreaEmitter{ColorParameter(factor, 0)}).name = "lamp";
  const Patch floor{{-5.0, 0.0, -4.0}, {0.0, 0.0, 10.0}, {10.0, 0.0, 0.0}, {dice.between(0.0, 1.0), 0.5}};
  scene.add(floor.mesh(), DiffuseBsdf{ColorParameter(albedo, 1)}).name = "floor";
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  scene.integrator.nee = strategy != LightStrategy::naive;
  scene.integrator.mis = strategy == LightStrategy::mis;
  scene.camera = look_along({0, 0.01, 0}, {0, -1, 0}, kPointFov);
  move_scene(scene, dice, true);
  const dvec3 reflected = albedo * floor_pattern.value(floor.uv + dvec2(0.4, 0.5)) / kPi;
  result.expected = luminance(reflected * factor * patch_irradiance(lamp, lamp_pattern));
  result.name = fmt::format("textures, lamp {}, floor {}, {}", lamp_pattern.name, floor_pattern.name,
                            light_strategy_name(strategy));
  return result;
}

}  // namespace etendue::closed_form
