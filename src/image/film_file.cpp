/// Films as EXR files: shards and checkpoints. The layout is documented in docs/image_files.md.

#include "image/film_file.h"

#include <algorithm>
#include <charconv>
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
#include "image/denoiser.h"
#include "image/exr_io.h"
#include "image/files.h"

namespace etendue {
namespace {

// Films without AOVs are of the first format.
constexpr int kFilmFormat = 1, kFilmFormatWithAovs = 2;
constexpr const char* kExponentAttribute = "filmExponent";
constexpr std::size_t kChecksumDigits = 32;
constexpr std::array<char, 3> kColors = {'R', 'G', 'B'};

/// One unsigned channel of a film file and the member of FilmPixel it holds.
struct Limb {
  std::string channel;
  std::size_t offset = 0;  ///< bytes from the start of FilmPixel
};

/// The channels of the picture's film, or of an AOV's: "Aov.depth.Sum.R.0".
std::vector<Limb> limbs(const char* aov = nullptr) {
  const std::string prefix = aov != nullptr ? fmt::format("Aov.{}.", aov) : "";
  std::vector<Limb> all;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t k = 0; k < 4; ++k) {
      all.push_back({fmt::format("{}Sum.{}.{}", prefix, kColors[c], k), offsetof(FilmPixel, sum) + 16 * c + 4 * k});
    }
    for (std::size_t k = 0; k < 6; ++k) {
      all.push_back({fmt::format("{}SumSquares.{}.{}", prefix, kColors[c], k),
                     offsetof(FilmPixel, sum_squares) + 24 * c + 4 * k});
    }
  }
  all.push_back({prefix + kSampleCount, offsetof(FilmPixel, count)});
  all.push_back({prefix + "Rejected", offsetof(FilmPixel, rejected)});
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

/// Channels of sums. Those without a bit set are not stored, except for the counts.
void add_sums(Imf::FrameBuffer& buffer, const Film& film, const char* aov, const Imath::Box2i& window) {
  const auto used = used_bits(film);
  for (const Limb& limb : limbs(aov)) {
    if (used[limb.offset / 4] == 0 && !limb.channel.ends_with(kSampleCount)) continue;
    add_slice(buffer, limb.channel, Imf::UINT, limb_base(film, limb), sizeof(FilmPixel), window);
  }
}

/// The destinations of the sums in the file.
void add_stored_sums(Imf::FrameBuffer& buffer, const Imf::Header& header, const Film& film, const char* aov) {
  for (const Limb& limb : limbs(aov)) {
    if (header.channels().findChannel(limb.channel) == nullptr) continue;
    add_slice(buffer, limb.channel, Imf::UINT, limb_base(film, limb), sizeof(FilmPixel), header.dataWindow());
  }
}

void add_picture(Imf::FrameBuffer& buffer, const Image& image, const Imath::Box2i& window) {
  for (int c = 0; c < 3; ++c) {
    const char color = kColors[static_cast<std::size_t>(c)];
    add_slice(buffer, std::string(1, color), Imf::FLOAT, &image.pixels[0][c], sizeof(glm::vec3), window);
    add_slice(buffer, fmt::format("StdErr.{}", color), Imf::FLOAT, &image.standard_error[0][c], sizeof(glm::vec3),
              window);
  }
  add_channels(buffer, image.channels, window);
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
    fail_on_file(path, fmt::format("its sample ranges {} are not sorted, disjoint and joined",
                                   text::quoted(to_text(file.samples))));
  }
  const std::uint64_t expected = sample_count(file.samples);
  const auto check = [&](const Film& film, std::uint64_t wanted, const std::string& what) {
    const auto& pixels = film.pixels();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const std::uint64_t seen = std::uint64_t{pixels[i].count} + pixels[i].rejected;
      if (seen == wanted) continue;
      fail_on_file(path,
                   fmt::format("pixel ({}, {}) has {} samples{}, but the sample ranges {} hold {}", i % film.width(),
                               i / film.width(), seen, what, text::quoted(to_text(file.samples)), wanted));
    }
  };
  check(file.film, expected, "");
  for (const AovFilm& aov : file.aovs) {
    const AovTraits& row = traits(aov.aov);
    const bool first = row.mean == AovMean::first;
    check(aov.film, first ? std::min<std::uint64_t>(expected, 1) : expected, fmt::format(" of {}", row.name));
  }
}

bool is_exponent(int exponent) {
  return exponent >= -149 && exponent <= 128;  // of the smallest and the largest float32
}

std::string list_of_headers(const std::vector<AovHeader>& aovs) {
  std::string list;
  for (const AovHeader& aov : aovs)
    list += fmt::format("{}{}:{}", list.empty() ? "" : " ", traits(aov.aov).name, aov.exponent);
  return list;
}

/// Nothing unless `list` is what list_of_headers() makes of a complete list.
std::optional<std::vector<AovHeader>> parse_aov_headers(const std::string& list) {
  std::vector<AovHeader> headers;
  std::vector<Aov> aovs;
  for (std::size_t start = 0; start < list.size();) {
    const std::size_t end = std::min(list.find(' ', start), list.size());
    const std::size_t colon = std::min(list.find(':', start), end);
    const std::optional<Aov> aov = aov_named(list.substr(start, colon - start));
    AovHeader header{aov.value_or(Aov::hit), 0};
    const char *number = list.data() + std::min(colon + 1, end), *number_end = list.data() + end;
    const auto [last, error] = std::from_chars(number, number_end, header.exponent);
    if (!aov || error != std::errc() || last != number_end || !is_exponent(header.exponent)) return {};
    headers.push_back(header);
    aovs.push_back(*aov);
    start = end + 1;
  }
  if (headers.empty() || aovs != complete(aovs) || list_of_headers(headers) != list) return {};
  return headers;
}

void refuse_denoised(const Imf::Header& header, const std::string& path) {
  const std::string why =
      denoised_complaint(path, exr_metadata(header), "is not a film: its samples are in another file");
  if (!why.empty()) throw Error(ErrorKind::file, why);
}

int film_integer(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::IntAttribute>(name);
  if (attribute == nullptr) fail_on_file(path, fmt::format("holds no film: its header has no integer \"{}\"", name));
  return attribute->value();
}

FilmHeader film_header(const Imf::Header& header, const std::string& path) {
  refuse_denoised(header, path);
  const int format = film_integer(header, kFormatAttribute, path);
  if (format != kFilmFormat && format != kFilmFormatWithAovs) {
    fail_on_file(path, fmt::format("holds a film of format {}; this program reads the formats {} and {}", format,
                                   kFilmFormat, kFilmFormatWithAovs));
  }
  FilmHeader film;
  film.exponent = film_integer(header, kExponentAttribute, path);
  if (!is_exponent(film.exponent)) {
    fail_on_file(path, fmt::format("has the film exponent {}; -149 to 128 are possible", film.exponent));
  }
  film.metadata = exr_metadata(header);
  if (format == kFilmFormatWithAovs) {
    const auto* list = header.findTypedAttribute<Imf::StringAttribute>(kAovsAttribute);
    const auto aovs = list != nullptr ? parse_aov_headers(list->value()) : std::nullopt;
    if (!aovs)
      fail_on_file(path, fmt::format("has {} as its list of AOVs; expected one like \"depth:7 normal:0\"",
                                     list != nullptr ? text::quoted(list->value()) : "nothing"));
    film.aovs = *aovs;
  }
  const auto samples = film.metadata.find("samples");
  if (samples == film.metadata.end()) fail_on_file(path, "holds no film: its header has no text \"samples\"");
  const std::optional<SampleRanges> ranges = parse_sample_ranges(samples->second);
  if (!ranges)
    fail_on_file(path, fmt::format("has the sample ranges {}; expected sorted ones like 0:64,128:192",
                                   text::quoted(samples->second)));
  film.samples = *ranges;
  const Imath::Box2i& window = header.dataWindow();
  if (window.min.x != 0 || window.min.y != 0)
    fail_on_file(path, "holds no film: its data window does not begin at (0, 0)");
  film.width = static_cast<std::uint32_t>(window.max.x) + 1;
  film.height = static_cast<std::uint32_t>(window.max.y) + 1;
  return film;
}

/// Throws unless the channels are the picture's and a selection of the limbs, all at full resolution.
void check_channels(const Imf::ChannelList& channels, const std::vector<AovHeader>& aovs, const std::string& path) {
  std::map<std::string, Imf::PixelType> known;
  for (const Limb& limb : limbs()) known[limb.channel] = Imf::UINT;
  for (const AovHeader& aov : aovs) {
    for (const Limb& limb : limbs(traits(aov.aov).name)) known[limb.channel] = Imf::UINT;
    for (const std::string& name : channel_names(aov.aov))
      known[name] = traits(aov.aov).mean == AovMean::first ? Imf::UINT : Imf::FLOAT;
  }
  for (const char color : kColors) {
    known[std::string(1, color)] = known[fmt::format("StdErr.{}", color)] = Imf::FLOAT;
    if (channels.findChannel(std::string(1, color)) == nullptr ||
        channels.findChannel(fmt::format("StdErr.{}", color)) == nullptr) {
      fail_on_file(path, fmt::format("holds no film: it lacks the channels {} and StdErr.{}", color, color));
    }
  }
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    const auto expected = known.find(channel.name());
    const Imf::Channel& c = channel.channel();
    if (expected == known.end() || c.type != expected->second || c.xSampling != 1 || c.ySampling != 1) {
      fail_on_file(path, fmt::format("holds no film: channel {} does not belong in one or has the wrong type",
                                     text::quoted(channel.name())));
    }
  }
}

std::vector<std::byte> encode_film(const FilmFile& file, const std::string& path) {
  const Film& film = file.film;
  const Metadata metadata = film_metadata(file);
  Imf::Header header = make_exr_header(film.width(), film.height(), metadata, path);
  for (const char* name : {kFormatAttribute, kExponentAttribute, kChecksumAttribute, kAovsAttribute}) {
    if (metadata.contains(name)) fail_on_file(path, fmt::format("{} cannot be metadata of a film", text::quoted(name)));
  }
  header.insert(kFormatAttribute, Imf::IntAttribute(file.aovs.empty() ? kFilmFormat : kFilmFormatWithAovs));
  if (!file.aovs.empty()) header.insert(kAovsAttribute, Imf::StringAttribute(list_of_headers(header_of(file).aovs)));
  header.insert(kExponentAttribute, Imf::IntAttribute(film.exponent()));
  header.insert(kChecksumAttribute, Imf::StringAttribute(std::string(kChecksumDigits, '0')));
  // The limbs are mostly noise or zero: deflate saves 8 % more but takes two to three times as long, and checkpoints
  // are frequent.
  header.compression() = Imf::RLE_COMPRESSION;

  const Image image = image_from_film(file);
  Imf::FrameBuffer buffer;
  add_picture(buffer, image, header.dataWindow());
  add_sums(buffer, film, nullptr, header.dataWindow());
  for (const AovFilm& aov : file.aovs) add_sums(buffer, aov.film, traits(aov.aov).name, header.dataWindow());
  std::vector<std::byte> bytes = encode_exr(header, buffer, path);
  const std::optional<ExrAttribute> attribute = find_checksum(bytes, path);
  if (!attribute) fail_on_file(path, "cannot be encoded: the checksum has no place in the header");
  const std::string checksum = file_checksum(bytes, *attribute);
  std::memcpy(bytes.data() + attribute->offset, checksum.data(), checksum.size());
  return bytes;
}

}  // namespace

FilmHeader header_of(const FilmFile& file) {
  FilmHeader header{file.film.width(), file.film.height(), file.film.exponent(), file.samples, file.metadata, {}};
  for (const AovFilm& aov : file.aovs) header.aovs.push_back({aov.aov, aov.film.exponent()});
  return header;
}

std::vector<AovFilm> empty_aovs(const FilmHeader& header) {
  std::vector<AovFilm> aovs;
  for (const AovHeader& aov : header.aovs) aovs.push_back({aov.aov, Film(header.width, header.height, aov.exponent)});
  return aovs;
}

Metadata film_metadata(const FilmFile& file) {
  Metadata metadata = file.metadata;
  metadata["samples"] = to_text(file.samples);
  metadata["rejected"] = std::to_string(file.film.rejected());
  return metadata;
}

void write_film(const std::string& path, const FilmFile& file) {
  if (file.film.pixels().empty()) fail_on_file(path, "cannot write a film without pixels");
  check_counts(file, path);
  write_file_atomically(path, encode_film(file, path));
}

FilmHeader read_film_header(const std::string& path) {
  return film_header(load_exr_header(path), path);
}

namespace {

ExrAttribute checksum_of_film(std::span<const std::byte> bytes, const std::string& path) {
  const std::optional<ExrAttribute> attribute = find_checksum(bytes, path);
  if (!attribute)
    fail_on_file(path, fmt::format("holds no film: its header has no \"{}\"; pictures cannot be merged or resumed",
                                   kChecksumAttribute));
  return *attribute;
}

void verify_checksum(std::span<const std::byte> bytes, const ExrAttribute& attribute, const std::string& path) {
  const std::string stored(reinterpret_cast<const char*>(bytes.data()) + attribute.offset, kChecksumDigits);
  if (const std::string actual = file_checksum(bytes, attribute); actual != stored)
    fail_on_file(path, fmt::format("is truncated or was changed: its checksum is {}, but it says {}", actual, stored));
}

}  // namespace

void verify_film(std::span<const std::byte> bytes, const std::string& path) {
  if (is_film(read_exr_header(bytes, path))) verify_checksum(bytes, checksum_of_film(bytes, path), path);
}

FilmFile decode_film(std::span<const std::byte> bytes, const std::string& path, bool verify) {
  if (!is_exr(bytes)) fail_on_file(path, "holds no film: it is not an EXR file");
  refuse_denoised(read_exr_header(bytes, path), path);
  const ExrAttribute checksum = checksum_of_film(bytes, path);
  if (verify) verify_checksum(bytes, checksum, path);
  const Imf::Header header = read_exr_header(bytes, path);
  FilmHeader described = film_header(header, path);
  check_channels(header.channels(), described.aovs, path);
  check_exr_size(header, bytes.size(), path);

  FilmFile file{Film(described.width, described.height, described.exponent), std::move(described.metadata),
                std::move(described.samples), empty_aovs(described)};
  Imf::FrameBuffer buffer;
  add_stored_sums(buffer, header, file.film, nullptr);
  for (const AovFilm& aov : file.aovs) add_stored_sums(buffer, header, aov.film, traits(aov.aov).name);
  decode_exr(bytes, buffer, path);
  check_counts(file, path);
  return file;
}

FilmFile read_film(const std::string& path) {
  try {
    if (!is_exr(read_file(path, 4))) fail_on_file(path, "holds no film: it is not an EXR file");
    return decode_film(read_whole_image(path), path, true);
  } catch (const std::bad_alloc&) {
    fail_on_file(path, "is too large for the memory of this machine");
  }
}

}  // namespace etendue
