#include "scene/lamp_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "image/vectors.h"
#include "scene/placed.h"
#include "scene/sharing.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

constexpr std::uint32_t kMostCells = 64;         // along a side
constexpr std::uint64_t kMostParts = 1u << 18;   // of all lamps
constexpr std::uint64_t kMostPoints = 1u << 22;  // likewise
constexpr std::uint32_t kMostPointsASide = 32;   // of a cell
constexpr double kEvenShare = 0.05;      // of the mean brightness, added everywhere: the points miss some of the light
constexpr double kLeastVariance = 0.05;  // relative; below it nothing is gained

std::uint32_t wrapped(double index, std::uint32_t size, TextureWrap wrap) {
  if (wrap != TextureWrap::clamp) {
    const double period = wrap == TextureWrap::mirror ? 2.0 * size : size;
    index -= period * std::floor(index / period);
    if (index >= size) index = 2.0 * size - 1.0 - index;
  }
  return static_cast<std::uint32_t>(std::clamp(index, 0.0, size - 1.0));
}

glm::dvec4 picture_color(const Scene& scene, const BitmapTexture& picture, const glm::dvec2& uv) {
  const Bitmap& bitmap = *scene.bitmaps[picture.bitmap];
  const ColorSpace space = picture.color_space.value_or(bitmap.color_space);
  const bool bilinear = picture.filter == TextureFilter::bilinear;
  const glm::dvec2 at = glm::dvec2(uv.x * bitmap.width, (1.0 - uv.y) * bitmap.height) - (bilinear ? 0.5 : 0.0);
  const glm::dvec2 corner = glm::floor(at), share = at - corner;
  const auto texel = [&](double i, double j) {
    return texel_color(bitmap, space, wrapped(corner.x + i, bitmap.width, picture.wrap_u),
                       wrapped(corner.y + j, bitmap.height, picture.wrap_v));
  };
  if (!bilinear) return texel(0, 0);
  return glm::mix(glm::mix(texel(0, 0), texel(1, 0), share.x), glm::mix(texel(0, 1), texel(1, 1), share.x), share.y);
}

glm::dvec2 place(const Texture& texture, const glm::dvec2& surface_uv) {
  return {texture.uv_transform * glm::dvec3(surface_uv, 1.0)};
}

// Of a picture or a checkerboard.
glm::dvec4 color_at(const Scene& scene, const Texture& texture, const glm::dvec2& surface_uv) {
  const glm::dvec2 uv = place(texture, surface_uv);
  if (const auto* picture = std::get_if<BitmapTexture>(&texture.source)) return picture_color(scene, *picture, uv);
  const auto& board = std::get<CheckerboardTexture>(texture.source);
  const bool even = std::fmod(std::floor(2.0 * uv.x) + std::floor(2.0 * uv.y), 2.0) == 0.0;
  const glm::dvec4 color(even ? board.color0 : board.color1, 1.0);
  const std::optional<std::uint32_t>& within = even ? board.texture0 : board.texture1;
  return within ? color * color_at(scene, scene.textures[*within], surface_uv) : color;
}

// The largest extent of the triangle along an axis of the texture, in texels of a picture or squares of a checkerboard.
double extent(const Scene& scene, const Texture& texture, const std::array<glm::dvec2, 3>& corners) {
  glm::dvec2 size(2.0);
  double most = 0.0;
  if (const auto* picture = std::get_if<BitmapTexture>(&texture.source)) {
    const Bitmap& bitmap = *scene.bitmaps[picture->bitmap];
    size = {bitmap.width, bitmap.height};
  } else {
    const auto& board = std::get<CheckerboardTexture>(texture.source);
    for (const std::optional<std::uint32_t>& within : {board.texture0, board.texture1}) {
      if (within) most = std::max(most, extent(scene, scene.textures[*within], corners));
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec2 edge = size * (place(texture, corners[(k + 1) % 3]) - place(texture, corners[k]));
    most = std::max({most, std::abs(edge.x), std::abs(edge.y)});
  }
  return most;
}

class LampDivider {
 public:
  LampDivider(KnownTextureFacts& facts, const Instance& instance, std::uint64_t lamps)
      : scene_(facts.scene()),
        lamps_(lamps),
        texture_(scene_.textures[*scene_.emitter_of(instance)->radiance.texture]),
        value_(scene_.emitter_of(instance)->radiance.value),
        mesh_(std::get<TriangleMesh>(scene_.shape_of(instance))),
        turned_(turns_winding(instance)),
        radiance_(facts, instance) {
    if (const auto* attribute = std::get_if<AttributeTexture>(&texture_.source)) {
      faces_ = attribute->source == AttributeTexture::Source::face_color;
      vertices_ = !faces_;
    } else {
      pictured_ = true;
      vertices_ = texture_.vertex_tint;
    }
  }

  // Nothing where the brightness hardly varies.
  std::optional<LampParts> divide() {
    choose_cells();
    LampParts parts{.cells = cells_, .first = {0}, .brightness = {}};
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      for (std::uint32_t cell = 0; cell < cells_[i] * cells_[i]; ++cell)
        parts.brightness.push_back(brightness(i, cell));
      parts.first.push_back(static_cast<std::uint32_t>(parts.brightness.size()));
    }
    if (!varies(parts)) return std::nullopt;
    return parts;
  }

 private:
  glm::uvec3 corners(std::size_t triangle) const {
    const glm::uvec3 t = mesh_.triangles[triangle];
    return turned_ ? glm::uvec3(t.x, t.z, t.y) : t;
  }

  std::array<glm::dvec2, 3> corner_uvs(std::size_t triangle) const {
    const glm::uvec3 t = corners(triangle);
    const std::vector<glm::vec2>& uvs = mesh_.uv_sets[texture_.uv_set];
    return {glm::dvec2(uvs[t.x]), glm::dvec2(uvs[t.y]), glm::dvec2(uvs[t.z])};
  }

  // About a texel each, and points in them for every texel, as far as the limits allow.
  void choose_cells() {
    constexpr double kSmooth = 8.0;  // cells along a side, for interpolated colours
    std::vector<double> extents(mesh_.triangles.size(), vertices_ ? kSmooth : 1.0);
    for (std::size_t i = 0; pictured_ && i < extents.size(); ++i)
      extents[i] = std::max(extents[i], extent(scene_, texture_, corner_uvs(i)));
    const auto divided = [&](std::uint32_t most) {
      std::vector<std::uint32_t> all;
      for (const double e : extents)
        all.push_back(std::bit_ceil(static_cast<std::uint32_t>(std::ceil(std::min<double>(e, most)))));
      return all;
    };
    const auto total = [](const std::vector<std::uint32_t>& all, std::uint64_t factor) {
      std::uint64_t sum = 0;
      for (const std::uint32_t n : all) sum += n * factor * n * factor;
      return sum;
    };
    std::uint32_t most = kMostCells;
    cells_ = divided(most);
    while (most > 1 && lamps_ * total(cells_, 1) > kMostParts) cells_ = divided(most /= 2);
    const double largest = extents.empty() ? 1.0 : *std::ranges::max_element(extents);
    points_ =
        std::bit_ceil(static_cast<std::uint32_t>(std::clamp(std::ceil(largest / most), 2.0, double{kMostPointsASide})));
    while (points_ > 1 && lamps_ * total(cells_, points_) > kMostPoints) points_ /= 2;
  }

  double brightness(std::size_t triangle, std::uint32_t cell) const {
    const std::uint32_t n = cells_[triangle];
    double sum = 0.0;
    for (std::uint32_t i = 0; i < points_; ++i) {
      for (std::uint32_t j = 0; j < points_; ++j) {
        const double u = (cell / n + (i + 0.5) / points_) / n, v = (cell % n + (j + 0.5) / points_) / n;
        const double root = std::sqrt(u);
        sum += luminance(color(triangle, {1.0 - root, root * v, root * (1.0 - v)}));
      }
    }
    return sum / (points_ * points_) + kEvenShare * luminance(radiance_.mean(triangle));
  }

  glm::dvec3 color(std::size_t triangle, const glm::dvec3& weights) const {
    glm::dvec4 color(1.0);
    if (pictured_) {
      const std::array<glm::dvec2, 3> uvs = corner_uvs(triangle);
      color = color_at(scene_, texture_, weights.x * uvs[0] + weights.y * uvs[1] + weights.z * uvs[2]);
    }
    if (vertices_) {
      const glm::uvec3 t = corners(triangle);
      glm::dvec4 tint(0.0);
      for (int k = 0; k < 3; ++k) {
        const double alpha = mesh_.vertex_alphas.empty() ? 1.0 : static_cast<double>(mesh_.vertex_alphas[t[k]]);
        tint += weights[k] * glm::dvec4(glm::dvec3(mesh_.vertex_colors[t[k]]), alpha);
      }
      color *= tint;
    }
    if (faces_) color = glm::dvec4(glm::dvec3(mesh_.face_colors[triangle]), 1.0);
    if (texture_.alpha_cutoff) color.a = color.a >= *texture_.alpha_cutoff ? 1.0 : 0.0;
    return value_ * glm::dvec3(color) * (texture_.premultiplied ? color.a : 1.0);
  }

  bool varies(const LampParts& parts) const {
    double area = 0.0, sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const double own = triangle_area(mesh_, mesh_.triangles[i]) / (cells_[i] * cells_[i]);
      for (std::uint32_t p = parts.first[i]; p < parts.first[i + 1]; ++p) {
        area += own;
        sum += own * parts.brightness[p];
        squares += own * parts.brightness[p] * parts.brightness[p];
      }
    }
    return squares * area > (1.0 + kLeastVariance) * sum * sum;
  }

  const Scene& scene_;
  const std::uint64_t lamps_;
  const Texture& texture_;
  const glm::dvec3 value_;
  const TriangleMesh& mesh_;
  const bool turned_;
  const EmitterRadiance radiance_;
  bool pictured_ = false, vertices_ = false, faces_ = false;  // what the colours come from
  std::vector<std::uint32_t> cells_;
  std::uint32_t points_ = 1;  // of a cell, along a side
};

}  // namespace

std::map<std::uint32_t, LampParts> lamp_parts(const Scene& scene) {
  std::vector<std::uint32_t> textured;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    const AreaEmitter* emitter = scene.emitter_of(scene.instances[i]);
    const bool mesh = std::holds_alternative<TriangleMesh>(scene.shape_of(scene.instances[i]));
    if (emitter != nullptr && emitter->radiance.texture && mesh) textured.push_back(i);
  }
  if (textured.empty()) return {};
  const Sharing sharing(scene);
  std::erase_if(textured, [&](std::uint32_t i) { return sharing.has_instance(i); });
  KnownTextureFacts facts(scene);
  std::map<std::uint32_t, LampParts> all;
  for (const std::uint32_t i : textured) {
    if (std::optional<LampParts> parts = LampDivider(facts, scene.instances[i], textured.size()).divide())
      all.emplace(i, std::move(*parts));
  }
  return all;
}

}  // namespace etendue
