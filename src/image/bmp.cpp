/// Windows bitmaps: 8-bit palettes, 24 and 32 bits, uncompressed, as found in old scenes.

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/decode.h"

namespace etendue {
namespace {

class BmpReader {
 public:
  BmpReader(std::span<const std::byte> bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  Bitmap read() {
    constexpr std::uint32_t kInfoHeader = 40;
    const std::uint32_t pixels = u32(10), header = u32(14);
    if (header < kInfoHeader) fail("its header is that of OS/2; save it again");
    const auto width = static_cast<std::int32_t>(u32(18)), height = static_cast<std::int32_t>(u32(22));
    const std::uint32_t bits = u16(28), compression = u32(30);
    if (compression != 0) fail("it is compressed or has bit masks; save it uncompressed");
    if (bits != 8 && bits != 24 && bits != 32) fail(fmt::format("it has {} bits a pixel; 8, 24 and 32 are read", bits));
    if (width < 1 || height == 0 || height == INT32_MIN) fail("it has no pixels");
    const auto columns = static_cast<std::uint64_t>(width), rows = static_cast<std::uint64_t>(std::abs(height));
    check_picture_size(columns, rows, path_);
    const std::uint64_t stride = (columns * bits + 31) / 32 * 4;
    if (pixels > bytes_.size() || rows * stride > bytes_.size() - pixels) fail("it ends before its last pixel");
    const std::size_t palette = 14 + std::size_t{header};
    const std::uint32_t colors = bits == 8 ? palette_size(palette, pixels) : 0;
    Bitmap bitmap = make_bitmap(columns, rows, 3, BitmapFormat::u8);
    bitmap.color_space = ColorSpace::srgb;
    for (std::uint64_t y = 0; y < rows; ++y) {
      const std::uint64_t row = pixels + stride * (height > 0 ? rows - 1 - y : y);  // the last row first
      for (std::uint64_t x = 0; x < columns; ++x) {
        std::uint64_t at = row + x * (bits / 8);
        if (bits == 8) {
          const auto index = std::to_integer<std::uint32_t>(bytes_[at]);
          if (index >= colors) fail(fmt::format("a pixel has colour {} of a palette of {}", index, colors));
          at = palette + 4 * index;
        }
        for (std::uint64_t c = 0; c < 3; ++c)  // blue, green, red
          bitmap.texels[3 * (y * columns + x) + c] = bytes_[at + 2 - c];
      }
    }
    return bitmap;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(ErrorKind::file, fmt::format("{}: cannot be read as BMP: {}", path_, reason));
  }

  std::uint32_t palette_size(std::size_t palette, std::size_t pixels) {
    const std::uint32_t used = u32(46);
    const std::uint32_t colors = used == 0 || used > 256 ? 256 : used;
    if (palette + 4 * std::size_t{colors} > pixels) fail("its palette is cut off");
    return colors;
  }

  std::uint32_t u16(std::size_t at) {
    if (at + 2 > bytes_.size()) fail("its header is cut off");
    return std::to_integer<std::uint32_t>(bytes_[at]) | std::to_integer<std::uint32_t>(bytes_[at + 1]) << 8;
  }
  std::uint32_t u32(std::size_t at) { return u16(at) | u16(at + 2) << 16; }

  std::span<const std::byte> bytes_;
  const std::string& path_;
};

}  // namespace

bool is_bmp(std::span<const std::byte> bytes) {
  return bytes.size() >= 18 && bytes[0] == std::byte{'B'} && bytes[1] == std::byte{'M'};
}

Bitmap decode_bmp(std::span<const std::byte> bytes, const std::string& path) {
  return BmpReader(bytes, path).read();
}

}  // namespace etendue
