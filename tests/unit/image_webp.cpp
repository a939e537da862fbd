/// WebP pictures, made by the library that reads them.

#include <webp/encode.h>

#include "core/errors.h"
#include "image/bitmap_bytes.h"
#include "image_testing.h"

namespace etendue::testing_image {
namespace {

using Encode = size_t (*)(const std::uint8_t*, int, int, int, std::uint8_t**);

std::vector<std::byte> webp(const std::vector<std::uint8_t>& codes, int width, int height, int channels,
                            const Encode& encode) {
  std::uint8_t* made = nullptr;
  const std::size_t size = encode(codes.data(), width, height, width * channels, &made);
  const auto* bytes = reinterpret_cast<const std::byte*>(made);
  std::vector<std::byte> result(bytes, bytes + size);
  WebPFree(made);
  return result;
}

TEST(Webp, LosslessCodesAreKept) {
  const std::vector<std::uint8_t> rgb = {1, 2, 3, 250, 0, 7}, rgba = {1, 2, 3, 255, 9, 8, 7, 100};
  const Bitmap color = decode_picture(webp(rgb, 2, 1, 3, WebPEncodeLosslessRGB), "a.webp");
  EXPECT_EQ(color.channels, 3u);
  EXPECT_EQ(color.color_space, ColorSpace::srgb);
  EXPECT_EQ(color.stored(1, 0, 0), 250.0f / 255.0f);
  const Bitmap alpha = decode_picture(webp(rgba, 2, 1, 4, WebPEncodeLosslessRGBA), "a.webp");
  EXPECT_EQ(alpha.channels, 4u);
  EXPECT_EQ(alpha.stored(1, 0, 3), 100.0f / 255.0f);
  EXPECT_EQ(alpha.stored(1, 0, 0), 9.0f / 255.0f);
}

TEST(Webp, DamagedFilesAreRefused) {
  std::vector<std::uint8_t> codes(64 * 64 * 3);
  for (std::size_t i = 0; i < codes.size(); ++i) codes[i] = static_cast<std::uint8_t>(i * i % 251);
  const std::vector<std::byte> whole = webp(codes, 64, 64, 3, WebPEncodeLosslessRGB);
  for (std::size_t size = 12; size < whole.size(); size += 97) {
    const std::span<const std::byte> part(whole.data(), size);
    EXPECT_THROW(decode_picture(part, "a.webp"), Error) << size;
  }
  EXPECT_THROW(decode_picture({}, "a.webp"), Error);
}

}  // namespace
}  // namespace etendue::testing_image
