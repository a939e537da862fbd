/// JPEG files, made by libjpeg in memory.

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
// After <cstdio>, which it needs and does not include.
#include <jpeglib.h>

#include "image/bitmap.h"
#include "image_testing.h"

namespace etendue {
namespace {

using testing::HasSubstr;
using testing_image::error_of;
using testing_image::spill;
using testing_image::TempFolder;

struct JpegKind {
  J_COLOR_SPACE space = JCS_RGB;
  int channels = 3;
  bool progressive = false;
};

constexpr unsigned kWidth = 37, kHeight = 21;

/// Smooth, so that little is lost.
std::uint8_t value_at(unsigned x, unsigned y, unsigned c) {
  return static_cast<std::uint8_t>(40 + 3 * x + (c == 1 ? 4 * y : c == 2 ? 90 : y));
}

std::string jpeg_bytes(const JpegKind& kind) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &memory, &size);
  jpeg.image_width = kWidth;
  jpeg.image_height = kHeight;
  jpeg.input_components = kind.channels;
  jpeg.in_color_space = kind.space;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, 98, TRUE);
  if (kind.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  for (unsigned y = 0; y < kHeight; ++y) {
    std::vector<JSAMPLE> row;
    for (unsigned x = 0; x < kWidth; ++x) {
      for (int c = 0; c < kind.channels; ++c) row.push_back(value_at(x, y, static_cast<unsigned>(c)));
    }
    JSAMPROW pointer = row.data();
    jpeg_write_scanlines(&jpeg, &pointer, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string bytes(reinterpret_cast<const char*>(memory), size);
  std::free(memory);
  return bytes;
}

TEST(Jpeg, ReadsColorAndGreySequentialAndProgressive) {
  const TempFolder folder;
  for (const bool progressive : {false, true}) {
    for (const bool grey : {false, true}) {
      spill(folder / "a.jpg", jpeg_bytes({grey ? JCS_GRAYSCALE : JCS_RGB, grey ? 1 : 3, progressive}));
      const Bitmap bitmap = read_bitmap(folder / "a.jpg");
      ASSERT_EQ(bitmap.width, kWidth);
      ASSERT_EQ(bitmap.height, kHeight);
      ASSERT_EQ(bitmap.channels, grey ? 1u : 3u);
      EXPECT_EQ(bitmap.format, BitmapFormat::u8);
      EXPECT_EQ(bitmap.color_space, ColorSpace::srgb);
      for (unsigned y = 0; y < kHeight; ++y) {
        for (unsigned x = 0; x < kWidth; ++x) {
          for (unsigned c = 0; c < bitmap.channels; ++c) {
            // Coding is lossy, colour at half the resolution.
            ASSERT_NEAR(255 * bitmap.stored(x, y, c), value_at(x, y, c), grey ? 3 : 12) << x << " " << y << " " << c;
          }
        }
      }
    }
  }
}

TEST(Jpeg, RefusesInks) {
  const TempFolder folder;
  spill(folder / "a.jpg", jpeg_bytes({JCS_CMYK, 4, false}));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.jpg"); }), HasSubstr("CMYK"));
}

TEST(Jpeg, RefusesEveryTruncation) {
  const TempFolder folder;
  for (const bool progressive : {false, true}) {
    const std::string whole = jpeg_bytes({JCS_RGB, 3, progressive});
    // The marker of the end, two bytes, is all that may be missing without a pixel lost; it counts, too.
    for (std::size_t length = 3; length < whole.size(); length += 7) {
      spill(folder / "b.jpg", whole.substr(0, length));
      EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.jpg"); }), HasSubstr("b.jpg: ")) << length;
    }
    spill(folder / "b.jpg", whole.substr(0, whole.size() - 2));
    EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.jpg"); }), HasSubstr("Premature end of JPEG file"));
  }
}

TEST(Jpeg, SurvivesEveryChangedByte) {
  const TempFolder folder;
  const std::string whole = jpeg_bytes({JCS_RGB, 3, true});
  for (std::size_t i = 0; i < whole.size(); i += 3) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x24);
    spill(folder / "b.jpg", bytes);
    // A JPEG has no checksum, so much passes; what does not is an Error with the name of the file.
    try {
      read_bitmap(folder / "b.jpg");
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("b.jpg: "));
    }
  }
}

TEST(Jpeg, RefusesSizesTheFileCannotHold) {
  const TempFolder folder;
  std::string bytes = jpeg_bytes({JCS_RGB, 3, false});
  const std::size_t frame = bytes.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  bytes.replace(frame + 5, 4, "\x1f\x40\x1f\x40");  // 8000 x 8000
  spill(folder / "a.jpg", bytes);
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.jpg"); }), HasSubstr("announces 8000x8000 pixels but has only"));
  bytes.replace(frame + 5, 4, "\xff\x40\x1f\x40");
  spill(folder / "a.jpg", bytes);
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.jpg"); }), HasSubstr("at most 67108864 in all"));
}

TEST(Jpeg, RefusesTooManyScans) {
  const TempFolder folder;
  const std::string whole = jpeg_bytes({JCS_GRAYSCALE, 1, true});
  // The last scan again and again.
  const std::size_t scan = whole.rfind("\xff\xda");
  ASSERT_NE(scan, std::string::npos);
  const std::string last = whole.substr(scan, whole.size() - 2 - scan);
  std::string bytes = whole.substr(0, whole.size() - 2);
  for (int i = 0; i < 300; ++i) bytes += last;
  spill(folder / "a.jpg", bytes + whole.substr(whole.size() - 2));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.jpg"); }), HasSubstr("a.jpg: is a damaged JPEG file: "));
}

}  // namespace
}  // namespace etendue
