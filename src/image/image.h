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

/// For a denoised picture: what denoised it.
inline constexpr const char* kDenoisedKey = "denoised";

struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<glm::vec3> pixels;            ///< size width · height
  std::vector<glm::vec3> standard_error;    ///< as long as pixels, or empty when unknown
  std::vector<std::uint32_t> sample_count;  ///< as long as pixels, or empty when unknown
  std::vector<ImageChannel> channels;       ///< other than colour, each as long as pixels; read on demand
  Metadata metadata;

  /// False for a denoised picture, whatever it contains: its errors are not those of a mean.
  bool has_statistics() const {
    return !standard_error.empty() && !sample_count.empty() && !metadata.contains(kDenoisedKey);
  }
};

/// The picture of a film.
Image image_from_film(const Film& film, Metadata metadata);
struct FilmFile;
/// The same, with all AOVs.
Image image_from_film(const FilmFile& file);

/// Reads EXR (float or half R,G,B or Y; StdErr.* and SampleCount if present) or PNG (sRGB, decoded to linear),
/// recognised by content. Throws Error(file) with the path and the reason; never returns a partly read image, nor the
/// picture of a film file that does not match its checksum. `beside`: additional floating-point channels of an EXR file
/// to read, if present.
Image read_image(const std::string& path, std::span<const std::string> beside = {});

/// Float32 EXR with R G B, StdErr.R/G/B and SampleCount (if known), the other channels, and the metadata as string
/// attributes. Written next to the target, fsynced and renamed: the target is written completely or stays as it was.
/// Throws Error(file).
void write_exr(const std::string& path, const Image& image);
/// 8-bit sRGB PNG of the picture after `display`, clamped to [0,1]; transparent by the channel A if there is one. The
/// metadata record what `display` changes: "toneMapping" and "exposure". Atomic like write_exr.
void write_png(const std::string& path, const Image& image, const Display& display = {});
/// The bytes of that file. `name` is for messages.
std::vector<std::byte> encode_png(const Image& image, const Display& display = {},
                                  const std::string& name = "the picture");

/// A film with everything needed to continue it: shards and checkpoints are such files. It is an EXR that any viewer
/// can open (R G B, StdErr.*, SampleCount) and whose additional unsigned channels hold the exact sums, with a checksum
/// over the whole file.
struct FilmFile {
  Film film;
  Metadata metadata;
  std::vector<std::pair<std::uint32_t, std::uint32_t>>
      samples;                ///< disjoint, sorted, half-open ranges of sample indices inside
  std::vector<AovFilm> aovs;  ///< beside the picture, in the order of Aov
};
void write_film(const std::string& path, const FilmFile& file);
/// Throws Error(file) that says what is wrong: not a film, truncated, checksum, impossible size, other version.
FilmFile read_film(const std::string& path);

}  // namespace etendue
