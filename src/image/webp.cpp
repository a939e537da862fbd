/// WebP pictures: lossy and lossless, with and without alpha, not animated.

#include <cstring>

#include <fmt/format.h>
#include <webp/decode.h>

#include "core/errors.h"
#include "image/decode.h"

namespace etendue {

bool is_webp(std::span<const std::byte> bytes) {
  return bytes.size() >= 12 && std::memcmp(bytes.data(), "RIFF", 4) == 0 &&
         std::memcmp(bytes.data() + 8, "WEBP", 4) == 0;
}

Bitmap decode_webp(std::span<const std::byte> bytes, const std::string& path) {
  const auto refuse = [&](const std::string& reason) {
    throw Error(ErrorKind::file, fmt::format("{}: {}", path, reason));
  };
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    refuse("is a damaged WebP file: its header cannot be read");
  if (features.has_animation != 0) refuse("is a WebP file that moves; save one of its pictures");
  const auto width = static_cast<std::uint64_t>(features.width), height = static_cast<std::uint64_t>(features.height);
  check_picture_size(width, height, path);
  const std::uint32_t channels = features.has_alpha != 0 ? 4 : 3;
  Bitmap bitmap = make_bitmap(width, height, channels, BitmapFormat::u8);
  bitmap.color_space = ColorSpace::srgb;
  auto* texels = reinterpret_cast<std::uint8_t*>(bitmap.texels.data());
  const auto stride = static_cast<int>(bitmap.row_bytes());
  const std::uint8_t* decoded = channels == 4
                                    ? WebPDecodeRGBAInto(data, bytes.size(), texels, bitmap.texels.size(), stride)
                                    : WebPDecodeRGBInto(data, bytes.size(), texels, bitmap.texels.size(), stride);
  if (decoded == nullptr) refuse("is a damaged WebP file: its pixels cannot be read");
  return bitmap;
}

}  // namespace etendue
