#include "scene/sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/parallel.h"

namespace etendue {
namespace {

/// Light of the 256 codes of 8 bits.
const std::array<double, 256>& srgb_table() {
  static const std::array<double, 256> table = [] {
    std::array<double, 256> values{};
    for (std::size_t code = 0; code < values.size(); ++code)
      values[code] = linear_from_srgb(static_cast<float>(code) / 255.0f);
    return values;
  }();
  return table;
}

double decoded(const Bitmap& bitmap, std::uint32_t x, std::uint32_t y, std::uint32_t channel) {
  if (bitmap.color_space == ColorSpace::linear) return bitmap.stored(x, y, channel);
  if (bitmap.format == BitmapFormat::u8)
    return srgb_table()[std::to_integer<std::size_t>(
        bitmap.texels[y * bitmap.row_bytes() + std::size_t{x} * bitmap.channels + channel])];
  return linear_from_srgb(bitmap.stored(x, y, channel));
}

}  // namespace

glm::vec3 SkyPicture::radiance(std::uint32_t x, std::uint32_t y) const {
  const auto channel = [&](std::uint32_t c) { return static_cast<float>(scale * decoded(*bitmap, x, y, c)); };
  return bitmap->channels < 3 ? glm::vec3(channel(0)) : glm::vec3(channel(0), channel(1), channel(2));
}

bool is_dark(const Sky& sky) {
  if (!sky.picture) return sky.top == glm::dvec3(0.0) && sky.horizon == glm::dvec3(0.0);
  return sky_statistics(*sky.picture).largest == 0.0;
}

SkyStatistics sky_statistics(const SkyPicture& picture) {
  const Bitmap& bitmap = *picture.bitmap;
  std::vector<SkyStatistics> of_row(bitmap.height);
  parallel_for(bitmap.height, 16, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t y = begin; y < end; ++y) {
      SkyStatistics& row = of_row[y];
      for (std::uint32_t x = 0; x < bitmap.width; ++x) {
        const glm::vec3 c = picture.radiance(x, static_cast<std::uint32_t>(y));
        for (int i = 0; i < 3; ++i) {
          row.largest = std::isfinite(c[i]) ? std::max<double>(row.largest, c[i]) : INFINITY;
          row.smallest = std::min<double>(row.smallest, c[i]);
        }
        row.mean += std::max({c.x, c.y, c.z});
      }
    }
  });
  SkyStatistics all;
  double weights = 0.0;
  for (std::uint32_t y = 0; y < bitmap.height; ++y) {
    // Good enough for both kinds of rows: the mean is a guide to ranges of numbers.
    const double weight = std::sin(std::numbers::pi * (y + 0.5) / bitmap.height);
    all.largest = std::max(all.largest, of_row[y].largest);
    all.smallest = std::min(all.smallest, of_row[y].smallest);
    all.mean += weight * of_row[y].mean / bitmap.width;
    weights += weight;
  }
  all.mean /= weights;
  return all;
}

}  // namespace etendue
