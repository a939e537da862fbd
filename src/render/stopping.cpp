#include "render/stopping.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "image/image.h"

namespace etendue {

double relative_standard_error(const Film& film) {
  const Image image = image_from_film(film, {});
  double squares = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const double error = image.standard_error[i][c];
      if (!std::isfinite(error)) return std::numeric_limits<double>::infinity();
      squares += error * error;
      sum += image.pixels[i][c];
    }
  }
  if (sum == 0.0) return std::numeric_limits<double>::infinity();
  const double n = 3.0 * static_cast<double>(image.pixels.size());
  return std::sqrt(squares / n) / std::abs(sum / n);
}

double stopping_error(const Film& film) {
  std::uint32_t fewest = std::numeric_limits<std::uint32_t>::max();
  for (const FilmPixel& pixel : film.pixels()) fewest = std::min(fewest, pixel.count);
  if (film.pixels().empty() || fewest < 2) return std::numeric_limits<double>::infinity();
  const double unseen = kUnseenBrightness * std::sqrt(3.0 / static_cast<double>(film.pixels().size())) / fewest;
  return std::hypot(relative_standard_error(film), unseen);
}

std::uint64_t next_error_check(std::uint64_t count, std::uint64_t first) {
  std::uint64_t check = first;
  // first · 2^k and first · 3/2 · 2^k in turn.
  while (check <= count) check = (check & (check - 1)) == 0 ? check / 2 * 3 : check / 3 * 4;
  return check;
}

bool is_error_check(std::uint64_t count, std::uint64_t first) {
  return count >= first && next_error_check(count - 1, first) == count;
}

std::uint64_t first_error_check(std::uint32_t set_size) {
  return std::max<std::uint64_t>(4, kFirstErrorCheck / set_size);
}

}  // namespace etendue
