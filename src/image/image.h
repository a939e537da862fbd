#pragma once
/// A finished picture and its files. Linear Rec. 709, row-major, top row first.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "image/aov.h"
#include "image/film.h"
#include "image/tone_mapping.h"

namespace etendue {

/// Header attributes of an image, by name ("scene", "sceneHash", "device", "seed", "samples", …): see
/// docs/image_files.md.
using Metadata = std::map<std::string, std::string>;

/// Of a denoised picture: what it was denoised by.
inline constexpr const char* kDenoisedKey = "denoised";

struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<glm::vec3> pixels;            ///< size width · height
  std::vector<glm::vec3> standard_error;    ///< as long as pixels, or empty when unknown
  std::vector<std::uint32_t> sample_count;  ///< as long as pixels, or empty when unknown
  std::vector<ImageChannel> channels;       ///< beside the colour, each as long as pixels; read on demand
  Metadata metadata;

  /// Not of a denoised picture, whatever it says: its errors are not those of a mean.
  bool has_statistics() const {
    return !standard_error.empty() && !sample_count.empty() && !metadata.contains(kDenoisedKey);
  }
};

/// The picture a film shows.
Image image_from_film(const Film& film, Metadata metadata);
struct FilmFile;
/// The same with everything that was rendered beside it.
Image image_from_film(const FilmFile& file);

/// Reads EXR (float or half R,G,B or Y; StdErr.* and SampleCount when present) or PNG (sRGB decoded to linear), by
/// content. Throws Error(file) with the path and the reason; never returns a partly read image, nor the picture
/// of a film file that does not match its checksum. `beside`: channels of real numbers of an EXR file to be read, too,
/// where it has them.
Image read_image(const std::string& path, std::span<const std::string> beside = {});

/// Float32 EXR with R G B, StdErr.R/G/B and SampleCount (when known), the other channels and the metadata as string
/// attributes. Written beside the target, fsynced and renamed: the target appears whole or stays as it was. Throws
/// Error(file).
void write_exr(const std::string& path, const Image& image);
/// 8-bit sRGB PNG of what `display` makes of the picture, clamped to [0,1]; transparent by the channel A where there is
/// one. What `display` changes is told in the metadata: "toneMapping" and "exposure". Atomic like write_exr.
void write_png(const std::string& path, const Image& image, const Display& display = {});
/// The bytes of that file. `name` is for messages.
std::vector<std::byte> encode_png(const Image& image, const Display& display = {},
                                  const std::string& name = "the picture");

/// A film with everything needed to go on with it: shards and checkpoints are this file. It is an EXR that any viewer
/// opens (R G B, StdErr.*, SampleCount) and whose extra unsigned channels hold the exact sums, with a checksum over all
/// of it.
struct FilmFile {
  Film film;
  Metadata metadata;
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      samples;                ///< disjoint, sorted, half-open ranges of sample indices inside
  std::vector<AovFilm> aovs;  ///< beside the picture, in the order of Aov
};
void write_film(const std::string& path, const FilmFile& file);
/// Throws Error(file) that says what is wrong: no film in it, truncated, checksum, impossible size, other
/// version.
FilmFile read_film(const std::string& path);

}  // namespace etendue
