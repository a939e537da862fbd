#pragma once
/// The header of a film file, without its pixels. write_film and read_film are in image.h.

#include <cstdint>
#include <string>

#include "image/image.h"
#include "image/sample_ranges.h"

namespace etendue {

struct FilmHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  int exponent = 0;
  SampleRanges samples;
  Metadata metadata;
  std::vector<AovHeader> aovs;
  bool operator==(const FilmHeader&) const = default;
};

/// Reads only the first bytes of the file; read_film verifies the checksum, which covers the whole file. Throws
/// Error(file).
FilmHeader read_film_header(const std::string& path);
FilmHeader header_of(const FilmFile& file);

/// Films of these sizes and exponents, without samples.
std::vector<AovFilm> empty_aovs(const FilmHeader& header);

/// The file's metadata, with the entries "samples" and "rejected" derived from the film. write_film writes these.
Metadata film_metadata(const FilmFile& file);

}  // namespace etendue
