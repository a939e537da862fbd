#pragma once
/// A picture on its way to a page: linear values in half precision.

#include <cstdint>
#include <string>
#include <vector>

#include "image/aov.h"
#include "image/film.h"
#include "view/http_server.h"

namespace etendue::view {

/// The nearest half-precision number, ties to even; finite values beyond the largest become that, NaN stays NaN.
std::uint16_t half_of(float value);

/// Red, green and blue of each pixel as halves, little-endian, row by row from the top: the mean of the samples, or the
/// standard error of it, which is infinite with fewer than two samples.
enum class Channel { mean, error };
Bytes packed(const Film& film, Channel channel);

/// What is seen beside the light, as 32-bit floats, all components of a pixel together.
struct Layer {
  std::uint64_t number = 0;  ///< another one for every layer that is made
  std::uint32_t width = 0, height = 0, components = 0;
  Bytes values;
};
/// Of the films of one AOV and of what its averages need. Numbers become floats, which hold those below 2^24.
Layer packed(const std::vector<AovFilm>& films, Aov aov);

}  // namespace etendue::view
