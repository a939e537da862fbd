#pragma once
/// Pictures in the form in which they are sent to a page: linear values in half precision.

#include <cstdint>
#include <string>
#include <vector>

#include "image/aov.h"
#include "image/film.h"
#include "view/http_server.h"

namespace etendue::view {

/// The nearest half-precision number, ties to even; finite values beyond the largest one become the largest, NaN stays
/// NaN.
std::uint16_t half_of(float value);

/// Red, green and blue of each pixel as halves, little-endian, row by row from the top: the mean of the samples, or its
/// standard error, which is infinite with fewer than two samples.
enum class Channel { mean, error };
Bytes packed(const Film& film, Channel channel);

/// An AOV as 32-bit floats, all components of a pixel together.
struct Layer {
  std::uint64_t number = 0;  ///< different for every layer that is made
  std::uint32_t width = 0, height = 0, components = 0;
  Bytes values;
};
/// Makes a layer from the films of one AOV and of those that its averages need. Object numbers become floats, exact
/// below 2^24.
Layer packed(const std::vector<AovFilm>& films, Aov aov);

}  // namespace etendue::view
