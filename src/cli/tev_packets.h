#pragma once
/// The network protocol of the viewer tev: docs/tev.md. Integers are little-endian, texts end in a zero, and a packet
/// begins with its length in bytes, including the four of the length itself.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace etendue::cli {

using Packet = std::vector<std::byte>;

/// Names of all channels of a picture, in the order in which updates have them: R, G, B, the standard error, the number
/// of samples, and the AOVs.
std::vector<std::string> tev_channels(const Image& image);

/// CreateImage (4): a black picture with this name, size and channels, which replaces one of the same name; the viewer
/// shows it.
Packet tev_create(const std::string& name, const Image& image);

/// UpdateImageV3 (6): the rows [first_row, first_row + rows) of all channels, float32, each with an offset and a stride
/// in floats. Colours are interleaved, everything else follows channel by channel.
Packet tev_update(const std::string& name, const Image& image, std::uint32_t first_row, std::uint32_t rows);

/// The number of rows for a packet of a few megabytes: at least one.
std::uint32_t tev_rows(const Image& image);

}  // namespace etendue::cli
