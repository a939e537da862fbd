#include "image/image.h"

#include <new>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "image/decode.h"
#include "image/files.h"
#include "image/film_file.h"

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

Image image_from_film(const FilmFile& file) {
  Image image = image_from_film(file.film, film_metadata(file));
  image.channels = channels_of(file.aovs);
  return image;
}

std::vector<std::byte> read_whole_image(const std::string& path) {
  std::vector<std::byte> bytes = read_file(path, kMaxImageBytes + 1);
  if (bytes.size() > kMaxImageBytes)
    throw Error(ErrorKind::file, fmt::format("{}: has more than {} bytes; no picture or film of at most {} pixels does",
                                             path, kMaxImageBytes, kMaxImagePixels));
  return bytes;
}

Image read_image(const std::string& path, std::span<const std::string> beside) {
  try {
    // Checks the type first, so that gigabytes of something else are not read.
    const std::vector<std::byte> head = read_file(path, 8);
    if (is_exr(head)) {
      const std::vector<std::byte> bytes = read_whole_image(path);
      verify_film(bytes, path);
      return decode_exr_image(bytes, path, beside);
    }
    if (is_png(head)) return decode_png(read_whole_image(path), path);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorKind::file, fmt::format("{}: is too large for the memory of this machine", path));
  }
  throw Error(ErrorKind::file, fmt::format("{}: is neither an EXR nor a PNG file", path));
}

}  // namespace etendue
