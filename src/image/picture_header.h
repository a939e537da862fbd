#pragma once
/// The header of a picture or film file, without its pixels.

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "image/sample_ranges.h"

namespace etendue {

struct PictureHeader {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool film = false;     ///< holds exact sums: can be merged and resumed
  SampleRanges samples;  ///< sample indices inside; empty if the file does not say
  Metadata metadata;
  std::vector<std::string> channels;  ///< names, of an EXR file
};

/// Reads only the first bytes of an EXR or PNG file (recognised by content), however large the picture is. Throws
/// Error(file) with the path and the reason.
PictureHeader read_picture_header(const std::string& path);

}  // namespace etendue
