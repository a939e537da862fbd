#include "scene/texture_facts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "image/vectors.h"
#include "scene/placed.h"

namespace etendue {
namespace {

/// Light of all 8-bit codes: a curve for every texel of a large picture would take minutes.
const std::array<double, 256>& code_lights() {
  static const std::array<double, 256> lights = [] {
    std::array<double, 256> all{};
    for (std::size_t code = 0; code < all.size(); ++code)
      all[code] = linear_from_srgb(static_cast<double>(code) / 255.0);
    return all;
  }();
  return lights;
}

TextureFacts bitmap_facts(const Bitmap& bitmap, ColorSpace color_space) {
  TextureFacts facts{.mean = glm::dvec3(0.0), .least = glm::dvec3(INFINITY), .largest = glm::dvec3(-INFINITY)};
  for (std::uint32_t y = 0; y < bitmap.height; ++y) {
    glm::dvec3 row(0.0);  // summed by rows, so that large pictures lose no precision
    for (std::uint32_t x = 0; x < bitmap.width; ++x) {
      const glm::dvec3 color(texel_color(bitmap, color_space, x, y));
      if (!is_finite(color)) {
        facts.finite = false;
        continue;
      }
      row += color;
      facts.least = glm::min(facts.least, color);
      facts.largest = glm::max(facts.largest, color);
    }
    facts.mean += row;
  }
  facts.mean /= static_cast<double>(bitmap.width) * static_cast<double>(bitmap.height);
  return facts;
}

/// Of what one kind of squares of a checkerboard shows: the mean over all of the texture that stands there.
TextureFacts square_facts(const Scene& scene, const glm::dvec3& color, const std::optional<std::uint32_t>& row) {
  TextureFacts facts{.mean = color, .least = color, .largest = color, .finite = is_finite(color)};
  if (!row) return facts;
  const TextureFacts within = texture_facts(scene, scene.textures[*row]);
  facts.mean *= within.mean;
  facts.least = glm::min(color * within.least, color * within.largest);
  facts.largest = glm::max(color * within.least, color * within.largest);
  facts.finite = facts.finite && within.finite;
  return facts;
}

}  // namespace

glm::dvec4 texel_color(const Bitmap& bitmap, ColorSpace color_space, std::uint32_t x, std::uint32_t y) {
  const auto color = [&](std::uint32_t channel) {
    const auto stored = static_cast<double>(bitmap.stored(x, y, channel));
    if (color_space == ColorSpace::linear) return stored;
    if (bitmap.format == BitmapFormat::u8) return code_lights()[static_cast<std::size_t>(std::lround(255.0 * stored))];
    return linear_from_srgb(stored);
  };
  const double alpha = bitmap.has_alpha() ? static_cast<double>(bitmap.stored(x, y, bitmap.channels - 1)) : 1.0;
  if (bitmap.channels < 3) return glm::dvec4(glm::dvec3(color(0)), alpha);
  return {color(0), color(1), color(2), alpha};
}

TextureFacts texture_facts(const Scene& scene, const Texture& texture) {
  if (const auto* picture = std::get_if<BitmapTexture>(&texture.source)) {
    const Bitmap& bitmap = *scene.bitmaps[picture->bitmap];
    return bitmap_facts(bitmap, picture->color_space.value_or(bitmap.color_space));
  }
  if (const auto* board = std::get_if<CheckerboardTexture>(&texture.source)) {
    const TextureFacts even = square_facts(scene, board->color0, board->texture0);
    const TextureFacts odd = square_facts(scene, board->color1, board->texture1);
    return {.mean = 0.5 * (even.mean + odd.mean),
            .least = glm::min(even.least, odd.least),
            .largest = glm::max(even.largest, odd.largest),
            .finite = even.finite && odd.finite};
  }
  return {};
}

glm::dvec3 mean_intensity(const Scene& scene, const DeltaLight& light) {
  if (!light.intensity.texture) return light.intensity.value;
  return light.intensity.value * texture_facts(scene, scene.textures[*light.intensity.texture]).mean;
}

glm::dvec3 largest_intensity(const Scene& scene, const DeltaLight& light) {
  if (!light.intensity.texture) return light.intensity.value;
  return light.intensity.value * texture_facts(scene, scene.textures[*light.intensity.texture]).largest;
}

const TextureFacts& KnownTextureFacts::of(std::uint32_t texture) {
  const auto [at, fresh] = known_.try_emplace(texture);
  if (fresh) at->second = texture_facts(scene_, scene_.textures[texture]);
  return at->second;
}

EmitterRadiance::EmitterRadiance(KnownTextureFacts& known, const Instance& instance) {
  const Scene& scene = known.scene();
  const ColorParameter& radiance = scene.emitter_of(instance)->radiance;
  mean_ = largest_ = radiance.value;
  if (!radiance.texture) return;
  const Texture& texture = scene.textures[*radiance.texture];
  if (const auto* attribute = std::get_if<AttributeTexture>(&texture.source)) {
    colors_ = &std::get<TriangleMesh>(scene.shape_of(instance));
    source_ = attribute->source;
    return;
  }
  if (texture.vertex_tint) colors_ = &std::get<TriangleMesh>(scene.shape_of(instance));
  const TextureFacts& facts = known.of(*radiance.texture);
  mean_ = radiance.value * facts.mean;
  largest_ = radiance.value * facts.largest;
}

glm::dvec3 EmitterRadiance::mean(std::size_t primitive) const {
  if (uniform()) return mean_;
  if (source_ == AttributeTexture::Source::face_color) return mean_ * glm::dvec3(colors_->face_colors[primitive]);
  const glm::uvec3 t = colors_->triangles[primitive];
  const std::vector<glm::vec3>& colors = colors_->vertex_colors;
  return mean_ * (glm::dvec3(colors[t.x]) + glm::dvec3(colors[t.y]) + glm::dvec3(colors[t.z])) / 3.0;
}

glm::dvec3 EmitterRadiance::mean_of_all() const {
  if (uniform()) return mean_;
  glm::dvec3 sum(0.0);
  double area = 0.0;
  for (std::size_t i = 0; i < colors_->triangles.size(); ++i) {
    const double own = triangle_area(*colors_, colors_->triangles[i]);
    sum += own * mean(i);
    area += own;
  }
  return area > 0.0 ? sum / area : sum;
}

double EmitterRadiance::largest() const {
  if (uniform()) return largest_component(largest_);
  const bool faces = source_ == AttributeTexture::Source::face_color;
  double largest = 0.0;
  for (const glm::vec3& color : faces ? colors_->face_colors : colors_->vertex_colors)
    largest = std::max(largest, largest_component(largest_ * glm::dvec3(color)));
  return largest;
}

}  // namespace etendue
