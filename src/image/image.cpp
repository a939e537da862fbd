#include "image/image.h"

#include "core/parallel.h"

namespace etendue {

Image image_from_film(const Film& film, Metadata metadata) {
  Image image;
  image.width = film.width();
  image.height = film.height();
  image.metadata = std::move(metadata);
  const std::size_t count = film.pixels().size();
  image.pixels.resize(count);
  image.standard_error.resize(count);
  image.sample_count.resize(count);
  parallel_for(count, 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      image.pixels[i] = film.mean(i);
      image.standard_error[i] = film.standard_error(i);
      image.sample_count[i] = film.pixels()[i].count;
    }
  });
  return image;
}

}  // namespace etendue
