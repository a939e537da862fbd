#pragma once
/// Pictures of skies made in code.

#include <cstring>
#include <functional>
#include <memory>

#include "scene/scene.h"

namespace etendue::test {

/// float32 RGB, texel by texel.
inline SkyPicture make_sky_picture(std::uint32_t width, std::uint32_t height, SkyPicture::Rows rows,
                                   const std::function<glm::vec3(std::uint32_t x, std::uint32_t y)>& radiance) {
  Bitmap bitmap{.width = width,
                .height = height,
                .channels = 3,
                .format = BitmapFormat::f32,
                .color_space = ColorSpace::linear,
                .texels = {},
                .notes = {}};
  bitmap.texels.resize(bitmap.row_bytes() * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const glm::vec3 value = radiance(x, y);
      std::memcpy(bitmap.texels.data() + (std::size_t{y} * width + x) * sizeof value, &value, sizeof value);
    }
  }
  return {.bitmap = std::make_shared<const Bitmap>(std::move(bitmap)), .scale = 1.0, .rows = rows};
}

/// Texels between 0 and 4, a third of them black, one with a sun.
inline SkyPicture make_random_sky(std::uint32_t width, std::uint32_t height, SkyPicture::Rows rows, float sun = 50.0f) {
  return make_sky_picture(width, height, rows, [=](std::uint32_t x, std::uint32_t y) {
    std::uint32_t h = (y * width + x + 1) * 0x9e3779b9u;
    h = (h ^ h >> 16) * 0x7feb352du;
    h = (h ^ h >> 15) * 0x846ca68bu;
    h ^= h >> 16;
    if (x == width / 3 && y == height / 3) return glm::vec3(sun, 0.8f * sun, 0.5f * sun);
    if (h % 3 == 0) return glm::vec3(0.0f);
    return glm::vec3(static_cast<float>(h & 1023), static_cast<float>(h >> 10 & 1023),
                     static_cast<float>(h >> 20 & 1023)) /
           256.0f;
  });
}

/// A turn and a mirror image, and a scale of no account.
inline glm::dmat3 oblique_turn() {
  const glm::dvec3 z = glm::normalize(glm::dvec3(0.3, -0.5, 0.8)),
                   x = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), z));
  return glm::dmat3(-2.0 * x, 2.0 * glm::cross(z, x), 2.0 * z);
}

}  // namespace etendue::test
