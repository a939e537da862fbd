#pragma once
/// A picture on its way to a page: linear values in half precision.

#include <cstdint>
#include <string>

#include "image/film.h"
#include "view/http_server.h"

namespace etendue::view {

/// The nearest half-precision number, ties to even; finite values beyond the largest become that, NaN stays NaN.
std::uint16_t half_of(float value);

/// Red, green and blue of each pixel as halves, little-endian, row by row from the top: the mean of the samples, or the
/// standard error of it, which is infinite with fewer than two samples.
enum class Channel { mean, error };
Bytes packed(const Film& film, Channel channel);

}  // namespace etendue::view
