#include "view/picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include <half.h>

#include "core/parallel.h"

namespace etendue::view {

std::uint16_t half_of(float value) {
  constexpr float kMost = 65504.0f;
  return half(std::isfinite(value) ? std::clamp(value, -kMost, kMost) : value).bits();
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

Layer packed(const std::vector<AovFilm>& films, Aov aov) {
  const std::vector<std::string> names = channel_names(aov);
  Layer layer{.width = films.front().film.width(),
              .height = films.front().film.height(),
              .components = static_cast<std::uint32_t>(names.size())};
  std::vector<float> values(films.front().film.pixels().size() * names.size());
  for (const ImageChannel& channel : channels_of(films)) {
    const auto component = std::find(names.begin(), names.end(), channel.name) - names.begin();
    if (component == static_cast<std::ptrdiff_t>(names.size())) continue;  // a film needed only for averages
    float* out = values.data() + component;
    for (std::size_t i = 0; i * names.size() < values.size(); ++i)
      out[i * names.size()] = channel.numbers.empty() ? channel.values[i] : static_cast<float>(channel.numbers[i]);
  }
  auto bytes = std::make_shared<std::string>(values.size() * sizeof(float), '\0');
  std::memcpy(bytes->data(), values.data(), bytes->size());
  layer.values = std::move(bytes);
  return layer;
}

}  // namespace etendue::view
