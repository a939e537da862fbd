/// Films as EXR files: shards and checkpoints. The layout is documented in docs/image_files.md.

#include "image/film_file.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <new>
#include <optional>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>
#include <xxhash.h>

#include "core/errors.h"
#include "core/printable.h"
#include "image/exr_io.h"
#include "image/files.h"

namespace etendue {
namespace {

constexpr int kFilmFormat = 1;
constexpr const char* kExponentAttribute = "filmExponent";
constexpr std::size_t kChecksumDigits = 32;
constexpr std::array<char, 3> kColors = {'R', 'G', 'B'};

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
  throw Error(ErrorKind::file, fmt::format("{}: {}", path, reason));
}

/// One unsigned channel of a film file and the member of FilmPixel it holds.
struct Limb {
  std::string channel;
  std::size_t offset = 0;  ///< bytes from the start of FilmPixel
};

std::vector<Limb> limbs() {
  std::vector<Limb> all;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 4; ++k) {
      all.push_back({fmt::format("Sum.{}.{}", kColors[c], k), offsetof(FilmPixel, sum) + 16 * c + 4 * k});
    }
    for (std::size_t k = 0; k < 6; ++k) {
      all.push_back(
          {fmt::format("SumSquares.{}.{}", kColors[c], k), offsetof(FilmPixel, sum_squares) + 24 * c + 4 * k});
    }
  }
  all.push_back({"SampleCount", offsetof(FilmPixel, count)});
  all.push_back({"Rejected", offsetof(FilmPixel, rejected)});
  return all;
}

/// The bits that are set in any pixel, word by word: channels without any are not stored.
std::array<std::uint32_t, sizeof(FilmPixel) / 4> used_bits(const Film& film) {
  std::array<std::uint32_t, sizeof(FilmPixel) / 4> used{};
  for (const FilmPixel& pixel : film.pixels()) {
    std::array<std::uint32_t, sizeof(FilmPixel) / 4> words;
    std::memcpy(words.data(), &pixel, sizeof pixel);
    for (std::size_t i = 0; i < words.size(); ++i) used[i] |= words[i];
  }
  return used;
}

const void* limb_base(const Film& film, const Limb& limb) {
  return reinterpret_cast<const std::byte*>(film.pixels().data()) + limb.offset;
}

void add_picture(Imf::FrameBuffer& buffer, const Image& image, const Imath::Box2i& window) {
  for (int c = 0; c < 3; ++c) {
    const char color = kColors[static_cast<std::size_t>(c)];
    add_slice(buffer, std::string(1, color), Imf::FLOAT, &image.pixels[0][c], sizeof(glm::vec3), window);
    add_slice(buffer, fmt::format("StdErr.{}", color), Imf::FLOAT, &image.standard_error[0][c], sizeof(glm::vec3),
              window);
  }
}

std::optional<ExrAttribute> find_checksum(std::span<const std::byte> bytes, const std::string& path) {
  for (const ExrAttribute& attribute : exr_attributes(bytes, path)) {
    if (attribute.name == kChecksumAttribute && attribute.type == "string" && attribute.size == kChecksumDigits)
      return attribute;
  }
  return {};
}

/// XXH3 (128 bits) of the whole file with '0' in place of the checksum's own digits.
std::string file_checksum(std::span<const std::byte> bytes, const ExrAttribute& attribute) {
  const std::string zeros(kChecksumDigits, '0');
  const auto after = bytes.subspan(attribute.offset + kChecksumDigits);
  XXH3_state_t* state = XXH3_createState();
  if (state == nullptr) throw std::bad_alloc();
  XXH3_128bits_reset(state);
  XXH3_128bits_update(state, bytes.data(), attribute.offset);
  XXH3_128bits_update(state, zeros.data(), zeros.size());
  XXH3_128bits_update(state, after.data(), after.size());
  const XXH128_hash_t hash = XXH3_128bits_digest(state);
  XXH3_freeState(state);
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

/// Throws unless every pixel has seen exactly the samples of the ranges.
void check_counts(const FilmFile& file, const std::string& path) {
  if (!is_canonical(file.samples)) {
    fail(path,
         fmt::format("its sample ranges {} are not sorted, disjoint and joined", text::quoted(to_text(file.samples))));
  }
  const std::uint64_t expected = sample_count(file.samples);
  const auto& pixels = file.film.pixels();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint64_t seen = std::uint64_t{pixels[i].count} + pixels[i].rejected;
    if (seen != expected) {
      fail(path, fmt::format("pixel ({}, {}) has {} samples, but the sample ranges {} hold {}", i % file.film.width(),
                             i / file.film.width(), seen, text::quoted(to_text(file.samples)), expected));
    }
  }
}

int film_integer(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::IntAttribute>(name);
  if (attribute == nullptr) fail(path, fmt::format("holds no film: its header has no integer \"{}\"", name));
  return attribute->value();
}

FilmHeader film_header(const Imf::Header& header, const std::string& path) {
  const int format = film_integer(header, kFormatAttribute, path);
  if (format != kFilmFormat) {
    fail(path, fmt::format("holds a film of format {}; this program reads format {}", format, kFilmFormat));
  }
  FilmHeader film;
  film.exponent = film_integer(header, kExponentAttribute, path);
  // Exponents of the smallest and the largest float32.
  if (film.exponent < -149 || film.exponent > 128) {
    fail(path, fmt::format("has the film exponent {}; -149 to 128 are possible", film.exponent));
  }
  film.metadata = exr_metadata(header);
  const auto samples = film.metadata.find("samples");
  if (samples == film.metadata.end()) fail(path, "holds no film: its header has no text \"samples\"");
  const std::optional<SampleRanges> ranges = parse_sample_ranges(samples->second);
  if (!ranges)
    fail(path, fmt::format("has the sample ranges {}; expected sorted ones like 0:64,128:192",
                           text::quoted(samples->second)));
  film.samples = *ranges;
  const Imath::Box2i& window = header.dataWindow();
  if (window.min.x != 0 || window.min.y != 0) fail(path, "holds no film: its data window does not begin at (0, 0)");
  film.width = static_cast<std::uint32_t>(window.max.x) + 1;
  film.height = static_cast<std::uint32_t>(window.max.y) + 1;
  return film;
}

/// Throws unless the channels are the picture's and a selection of the limbs, all at full resolution.
void check_channels(const Imf::ChannelList& channels, const std::string& path) {
  std::map<std::string, Imf::PixelType> known;
  for (const Limb& limb : limbs()) known[limb.channel] = Imf::UINT;
  for (const char color : kColors) {
    known[std::string(1, color)] = known[fmt::format("StdErr.{}", color)] = Imf::FLOAT;
    if (channels.findChannel(std::string(1, color)) == nullptr ||
        channels.findChannel(fmt::format("StdErr.{}", color)) == nullptr) {
      fail(path, fmt::format("holds no film: it lacks the channels {} and StdErr.{}", color, color));
    }
  }
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    const auto expected = known.find(channel.name());
    const Imf::Channel& c = channel.channel();
    if (expected == known.end() || c.type != expected->second || c.xSampling != 1 || c.ySampling != 1) {
      fail(path, fmt::format("holds no film: channel {} does not belong into one or has the wrong type",
                             text::quoted(channel.name())));
    }
  }
}

std::vector<std::byte> encode_film(const Film& film, const Metadata& metadata, const std::string& path) {
  Imf::Header header = make_exr_header(film.width(), film.height(), metadata, path);
  for (const char* name : {kFormatAttribute, kExponentAttribute, kChecksumAttribute}) {
    if (metadata.contains(name)) fail(path, fmt::format("{} cannot be metadata of a film", text::quoted(name)));
  }
  header.insert(kFormatAttribute, Imf::IntAttribute(kFilmFormat));
  header.insert(kExponentAttribute, Imf::IntAttribute(film.exponent()));
  header.insert(kChecksumAttribute, Imf::StringAttribute(std::string(kChecksumDigits, '0')));
  // The limbs are mostly noise or zero: deflate saves 8 % more but takes two to three times as long, and checkpoints
  // are frequent.
  header.compression() = Imf::RLE_COMPRESSION;

  const Image image = image_from_film(film, {});
  Imf::FrameBuffer buffer;
  add_picture(buffer, image, header.dataWindow());
  const auto used = used_bits(film);
  for (const Limb& limb : limbs()) {
    if (used[limb.offset / 4] == 0 && limb.channel != "SampleCount") continue;
    add_slice(buffer, limb.channel, Imf::UINT, limb_base(film, limb), sizeof(FilmPixel), header.dataWindow());
  }
  std::vector<std::byte> bytes = encode_exr(header, buffer, path);
  const std::optional<ExrAttribute> attribute = find_checksum(bytes, path);
  if (!attribute) fail(path, "cannot be encoded: the checksum has no place in the header");
  const std::string checksum = file_checksum(bytes, *attribute);
  std::memcpy(bytes.data() + attribute->offset, checksum.data(), checksum.size());
  return bytes;
}

}  // namespace

FilmHeader header_of(const FilmFile& file) {
  return {file.film.width(), file.film.height(), file.film.exponent(), file.samples, file.metadata};
}

Metadata film_metadata(const FilmFile& file) {
  Metadata metadata = file.metadata;
  metadata["samples"] = to_text(file.samples);
  metadata["rejected"] = std::to_string(file.film.rejected());
  return metadata;
}

void write_film(const std::string& path, const FilmFile& file) {
  if (file.film.pixels().empty()) fail(path, "cannot write a film without pixels");
  check_counts(file, path);
  write_file_atomically(path, encode_film(file.film, film_metadata(file), path));
}

FilmHeader read_film_header(const std::string& path) {
  return film_header(load_exr_header(path), path);
}

namespace {

ExrAttribute checksum_of_film(std::span<const std::byte> bytes, const std::string& path) {
  const std::optional<ExrAttribute> attribute = find_checksum(bytes, path);
  if (!attribute)
    fail(path, fmt::format("holds no film: its header has no \"{}\"; pictures cannot be merged or resumed",
                           kChecksumAttribute));
  return *attribute;
}

void verify_checksum(std::span<const std::byte> bytes, const ExrAttribute& attribute, const std::string& path) {
  const std::string stored(reinterpret_cast<const char*>(bytes.data()) + attribute.offset, kChecksumDigits);
  if (const std::string actual = file_checksum(bytes, attribute); actual != stored)
    fail(path, fmt::format("is truncated or was changed: its checksum is {}, but it says {}", actual, stored));
}

}  // namespace

void verify_film(std::span<const std::byte> bytes, const std::string& path) {
  if (is_film(read_exr_header(bytes, path))) verify_checksum(bytes, checksum_of_film(bytes, path), path);
}

FilmFile decode_film(std::span<const std::byte> bytes, const std::string& path, bool verify) {
  if (!is_exr(bytes)) fail(path, "holds no film: it is not an EXR file");
  const ExrAttribute checksum = checksum_of_film(bytes, path);
  if (verify) verify_checksum(bytes, checksum, path);
  const Imf::Header header = read_exr_header(bytes, path);
  FilmHeader described = film_header(header, path);
  check_channels(header.channels(), path);
  check_exr_size(header, bytes.size(), path);

  FilmFile file{Film(described.width, described.height, described.exponent), std::move(described.metadata),
                std::move(described.samples)};
  Imf::FrameBuffer buffer;
  for (const Limb& limb : limbs()) {
    if (header.channels().findChannel(limb.channel) == nullptr) continue;
    add_slice(buffer, limb.channel, Imf::UINT, limb_base(file.film, limb), sizeof(FilmPixel), header.dataWindow());
  }
  decode_exr(bytes, buffer, path);
  check_counts(file, path);
  return file;
}

FilmFile read_film(const std::string& path) {
  try {
    if (!is_exr(read_file(path, 4))) fail(path, "holds no film: it is not an EXR file");
    return decode_film(read_whole_image(path), path, true);
  } catch (const std::bad_alloc&) {
    fail(path, "is too large for the memory of this machine");
  }
}

}  // namespace etendue
