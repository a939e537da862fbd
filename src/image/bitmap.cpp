#include "image/bitmap.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <new>
#include <string_view>

#include <fmt/format.h>
#include <glm/gtc/packing.hpp>

#include "core/errors.h"
#include "core/text.h"
#include "image/bitmap_bytes.h"
#include "image/decode.h"
#include "image/files.h"

namespace etendue {

static_assert(std::endian::native == std::endian::little, "texels are little-endian");

std::size_t bytes_of(BitmapFormat format) {
  switch (format) {
    case BitmapFormat::u8:
      return 1;
    case BitmapFormat::f16:
      return 2;
    case BitmapFormat::f32:
      break;
  }
  return 4;
}

std::size_t Bitmap::row_bytes() const {
  return std::size_t{width} * channels * bytes_of(format);
}

float Bitmap::stored(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const {
  const std::byte* at = texels.data() + y * row_bytes() + (std::size_t{x} * channels + channel) * bytes_of(format);
  switch (format) {
    case BitmapFormat::u8:
      return static_cast<float>(std::to_integer<unsigned>(*at)) / 255.0f;
    case BitmapFormat::f16: {
      std::uint16_t half = 0;
      std::memcpy(&half, at, sizeof half);
      return glm::unpackHalf1x16(half);
    }
    case BitmapFormat::f32:
      break;
  }
  float value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

std::size_t clear_negative_values(Bitmap& bitmap) {
  const std::size_t size = bytes_of(bitmap.format);
  if (size == 1) return 0;
  std::size_t count = 0;
  for (std::size_t at = 0; at + size <= bitmap.texels.size(); at += size) {
    // Little-endian: the sign is the last byte's highest bit. NaN, whose exponent has all bits set, is left for later
    // checks.
    const bool negative = (bitmap.texels[at + size - 1] & std::byte{0x80}) != std::byte{0};
    const std::size_t index = at / size;
    if (!negative) continue;
    const auto channel = static_cast<std::uint32_t>(index % bitmap.channels);
    const auto x = static_cast<std::uint32_t>(index / bitmap.channels % bitmap.width);
    const auto y = static_cast<std::uint32_t>(index / bitmap.channels / bitmap.width);
    if (!(bitmap.stored(x, y, channel) < 0.0f)) continue;
    std::memset(&bitmap.texels[at], 0, size);
    ++count;
  }
  return count;
}

double linear_from_srgb(double code) {
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

Bitmap make_bitmap(std::uint64_t width, std::uint64_t height, std::uint32_t channels, BitmapFormat format) {
  Bitmap bitmap;
  bitmap.width = static_cast<std::uint32_t>(width);
  bitmap.height = static_cast<std::uint32_t>(height);
  bitmap.channels = channels;
  bitmap.format = format;
  bitmap.texels.resize(bitmap.row_bytes() * bitmap.height);
  return bitmap;
}

void check_picture_size(std::uint64_t width, std::uint64_t height, const std::string& path) {
  if (width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide &&
      width * height <= kMaxImagePixels)
    return;
  throw Error(ErrorKind::file,
              fmt::format("{}: has {}x{} pixels; files hold 1 to {} a side and at most {} in all, so make it smaller",
                          path, width, height, kMaxImageSide, kMaxImagePixels));
}

Bitmap decode_bitmap(std::span<const std::byte> bytes, const std::string& path, const BitmapOptions& options) {
  if (is_exr(bytes)) return decode_exr_bitmap(bytes, path, options.layer);
  if (is_png(bytes)) return decode_png_bitmap(bytes, path);
  if (is_jpeg(bytes)) return decode_jpeg(bytes, path);
  if (is_webp(bytes)) return decode_webp(bytes, path);
  if (is_bmp(bytes)) return decode_bmp(bytes, path);
  return decode_hdr(bytes, path);
}

namespace {

bool is_picture(std::span<const std::byte> head) {
  return is_exr(head) || is_png(head) || is_jpeg(head) || is_webp(head) || is_bmp(head) || is_hdr(head);
}

[[noreturn]] void refuse_kind(const std::string& path) {
  throw Error(
      ErrorKind::file,
      fmt::format("{}: is not a PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR file; convert it to one of these", path));
}

[[noreturn]] void refuse_size(const std::string& path) {
  throw Error(ErrorKind::file, fmt::format("{}: is too large for the memory of this machine", path));
}

}  // namespace

Bitmap read_bitmap(const std::string& path, const BitmapOptions& options) {
  try {
    // The kind first: gigabytes of something else need not be read.
    const std::vector<std::byte> head = read_file(path, 64);
    if (const char* pointer = text::pointer_sentence({reinterpret_cast<const char*>(head.data()), head.size()}))
      throw Error(ErrorKind::file, fmt::format("{}: {}", path, pointer));
    if (head.empty()) throw Error(ErrorKind::file, fmt::format("{}: is empty; expected a picture", path));
    if (!is_picture(head)) refuse_kind(path);
    return decode_bitmap(read_whole_image(path), path, options);
  } catch (const std::bad_alloc&) {
    refuse_size(path);
  }
}

Bitmap decode_picture(std::span<const std::byte> bytes, const std::string& name) {
  try {
    if (!is_picture(bytes)) refuse_kind(name);
    return decode_bitmap(bytes, name);
  } catch (const std::bad_alloc&) {
    refuse_size(name);
  }
}

}  // namespace etendue
