#include "image/picture_header.h"

#include <filesystem>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/decode.h"
#include "image/exr_io.h"
#include "image/files.h"
#include "image/film_file.h"

namespace etendue {
namespace {

PictureHeader from_film(FilmHeader film) {
  return {film.width, film.height, true, std::move(film.samples), std::move(film.metadata), {}};
}

SampleRanges samples_in(const Metadata& metadata) {
  const auto samples = metadata.find("samples");
  return samples == metadata.end() ? SampleRanges{} : parse_sample_ranges(samples->second).value_or(SampleRanges{});
}

PictureHeader read_exr_picture_header(const std::string& path) {
  const Imf::Header header = load_exr_header(path);
  std::vector<std::string> channels;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
    channels.emplace_back(channel.name());
  if (is_film(header)) {
    PictureHeader film = from_film(read_film_header(path));
    film.channels = std::move(channels);
    return film;
  }
  const Imath::Box2i& window = header.dataWindow();
  PictureHeader picture{.width = static_cast<std::uint32_t>(window.max.x - window.min.x) + 1,
                        .height = static_cast<std::uint32_t>(window.max.y - window.min.y) + 1,
                        .metadata = exr_metadata(header),
                        .channels = std::move(channels)};
  picture.samples = samples_in(picture.metadata);
  return picture;
}

PictureHeader read_png_picture_header(const std::string& path) {
  // In files written by Etendue, texts come before the pixels and are shorter than this.
  constexpr std::uint64_t kLongest = 1 << 24;
  PictureHeader picture = decode_png_header(read_file(path, kLongest), std::filesystem::file_size(path), path);
  picture.samples = samples_in(picture.metadata);
  return picture;
}

}  // namespace

PictureHeader read_picture_header(const std::string& path) {
  const std::vector<std::byte> head = read_file(path, 8);
  if (is_exr(head)) return read_exr_picture_header(path);
  if (is_png(head)) return read_png_picture_header(path);
  throw Error(ErrorKind::file, fmt::format("{}: is neither an EXR nor a PNG file", path));
}

}  // namespace etendue
