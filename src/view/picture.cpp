#include "view/picture.h"

#include <bit>
#include <cmath>

#include "core/parallel.h"

namespace etendue::view {

std::uint16_t half_of(float value) {
  const auto all = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = (all >> 16) & 0x8000u, bits = all & 0x7fffffffu;
  constexpr std::uint32_t kInfinite = 0x7f800000u, kTooLarge = 0x477ff000u, kLeastNormal = 0x38800000u;
  if (bits > kInfinite) return static_cast<std::uint16_t>(sign | 0x7e00u);
  if (bits == kInfinite) return static_cast<std::uint16_t>(sign | 0x7c00u);
  if (bits >= kTooLarge) return static_cast<std::uint16_t>(sign | 0x7bffu);
  if (bits < kLeastNormal) {
    const float steps = std::nearbyint(std::bit_cast<float>(bits) * 0x1p24f);
    return static_cast<std::uint16_t>(sign | static_cast<std::uint32_t>(steps));
  }
  const std::uint32_t rounded = bits + 0xfffu + ((bits >> 13) & 1u);
  return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000u) >> 13));
}

Bytes packed(const Film& film, Channel channel) {
  const std::size_t pixels = film.pixels().size();
  auto bytes = std::make_shared<std::string>(pixels * 6, '\0');
  parallel_for(pixels, 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      const glm::vec3 value = channel == Channel::mean ? film.mean(i) : film.standard_error(i);
      for (int c = 0; c < 3; ++c) {
        const std::uint16_t half = half_of(value[c]);
        (*bytes)[i * 6 + 2 * c] = static_cast<char>(half & 0xffu);
        (*bytes)[i * 6 + 2 * c + 1] = static_cast<char>(half >> 8);
      }
    }
  });
  return bytes;
}

}  // namespace etendue::view
