/// Radiance HDR files, written here byte by byte.

#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "image/bitmap.h"
#include "image_testing.h"

namespace etendue {
namespace {

using testing::HasSubstr;
using testing_image::error_of;
using testing_image::spill;
using testing_image::TempFolder;

using Rgbe = std::array<std::uint8_t, 4>;

/// Pixel (x, y) of a picture: no two are alike.
Rgbe pixel_at(unsigned x, unsigned y) {
  return {static_cast<std::uint8_t>(10 + x), static_cast<std::uint8_t>(100 + y),
          static_cast<std::uint8_t>(x / 4 * 16 + 3), static_cast<std::uint8_t>(120 + y)};
}

std::string header_with(const std::string& size, const std::string& variables = "FORMAT=32-bit_rle_rgbe\n") {
  return "#?RADIANCE\n# a comment\n" + variables + "\n" + size + "\n";
}

std::string bytes_of_pixel(const Rgbe& pixel) {
  return std::string(reinterpret_cast<const char*>(pixel.data()), 4);
}

/// A scan line in the newer coding: runs where three bytes or more are equal.
std::string packed(const std::vector<Rgbe>& line) {
  std::string bytes = {2, 2, static_cast<char>(line.size() >> 8), static_cast<char>(line.size())};
  for (std::size_t plane = 0; plane < 4; ++plane) {
    for (std::size_t x = 0; x < line.size();) {
      std::size_t run = 1;
      while (x + run < line.size() && run < 127 && line[x + run][plane] == line[x][plane]) ++run;
      if (run > 2) {
        bytes += {static_cast<char>(128 + run), static_cast<char>(line[x][plane])};
      } else {
        run = 1;
        bytes += {1, static_cast<char>(line[x][plane])};
      }
      x += run;
    }
  }
  return bytes;
}

void expect_picture(const Bitmap& bitmap, unsigned width, unsigned height) {
  ASSERT_EQ(bitmap.width, width);
  ASSERT_EQ(bitmap.height, height);
  ASSERT_EQ(bitmap.channels, 3u);
  EXPECT_EQ(bitmap.format, BitmapFormat::f32);
  EXPECT_EQ(bitmap.color_space, ColorSpace::linear);
  for (unsigned y = 0; y < height; ++y) {
    for (unsigned x = 0; x < width; ++x) {
      const Rgbe pixel = pixel_at(x, y);
      for (unsigned c = 0; c < 3; ++c)
        ASSERT_EQ(bitmap.stored(x, y, c), std::ldexp(pixel[c], pixel[3] - 136)) << x << " " << y << " " << c;
    }
  }
}

TEST(Hdr, ReadsEveryOrientationPackedAndPlain) {
  const TempFolder folder;
  for (const bool rows : {true, false}) {
    for (const bool x_backward : {false, true}) {
      for (const bool y_backward : {false, true}) {
        for (const bool pack : {false, true}) {
          constexpr unsigned kWidth = 13, kHeight = 9;
          const std::string x_axis = std::string(x_backward ? "-X " : "+X ") + std::to_string(kWidth);
          const std::string y_axis = std::string(y_backward ? "+Y " : "-Y ") + std::to_string(kHeight);
          std::string file = header_with(rows ? y_axis + " " + x_axis : x_axis + " " + y_axis);
          for (unsigned line = 0; line < (rows ? kHeight : kWidth); ++line) {
            std::vector<Rgbe> pixels;
            for (unsigned i = 0; i < (rows ? kWidth : kHeight); ++i) {
              const unsigned x = rows ? i : line, y = rows ? line : i;
              pixels.push_back(pixel_at(x_backward ? kWidth - 1 - x : x, y_backward ? kHeight - 1 - y : y));
            }
            if (pack) {
              file += packed(pixels);
            } else {
              for (const Rgbe& pixel : pixels) file += bytes_of_pixel(pixel);
            }
          }
          spill(folder / "a.hdr", file);
          SCOPED_TRACE(x_axis + y_axis + (rows ? " rows" : " columns") + (pack ? " packed" : " plain"));
          expect_picture(read_bitmap(folder / "a.hdr"), kWidth, kHeight);
        }
      }
    }
  }
}

TEST(Hdr, ReadsOldRuns) {
  const TempFolder folder;
  const Rgbe a = {200, 1, 1, 130}, b = {1, 2, 1, 128};
  // a, three more of it, b, and 0x0103 = 3 + 256 more of it in two digits.
  const std::string file = header_with("-Y 1 +X 264") + bytes_of_pixel(a) + bytes_of_pixel({1, 1, 1, 3}) +
                           bytes_of_pixel(b) + bytes_of_pixel({1, 1, 1, 3}) + bytes_of_pixel({1, 1, 1, 1});
  spill(folder / "a.hdr", file);
  const Bitmap bitmap = read_bitmap(folder / "a.hdr");
  for (unsigned x = 0; x < 264; ++x)
    EXPECT_EQ(bitmap.stored(x, 0, 0), x < 4 ? std::ldexp(200.0f, -6) : std::ldexp(1.0f, -8)) << x;
  spill(folder / "b.hdr", file.substr(0, file.size() - 1));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.hdr"); }), HasSubstr("truncated"));
  spill(folder / "c.hdr", header_with("-Y 1 +X 3") + bytes_of_pixel(a) + bytes_of_pixel({1, 1, 1, 3}));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "c.hdr"); }),
              HasSubstr("a run of 3 pixels in a line that has 2 left"));
  spill(folder / "d.hdr", header_with("-Y 1 +X 3") + bytes_of_pixel({1, 1, 1, 3}));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "d.hdr"); }), HasSubstr("a run of 3 pixels"));
}

TEST(Hdr, ExponentZeroIsBlack) {
  const TempFolder folder;
  spill(folder / "a.hdr",
        header_with("-Y 1 +X 2") + bytes_of_pixel({255, 255, 255, 0}) + bytes_of_pixel({128, 64, 32, 129}));
  const Bitmap bitmap = read_bitmap(folder / "a.hdr");
  EXPECT_EQ(bitmap.stored(0, 0, 0), 0);
  EXPECT_EQ(bitmap.stored(1, 0, 0), 1);
  EXPECT_EQ(bitmap.stored(1, 0, 1), 0.5f);
  EXPECT_EQ(bitmap.stored(1, 0, 2), 0.25f);
}

TEST(Hdr, UndoesExposures) {
  const TempFolder folder;
  const std::string variables =
      "EXPOSURE=2\nFORMAT=32-bit_rle_rgbe\nEXPOSURE= 4\nCOLORCORR= 1 2 0.5\nPRIMARIES= 0 0 0 0 0 0 0 0\n";
  spill(folder / "a.hdr", header_with("-Y 1 +X 1", variables) + bytes_of_pixel({128, 128, 128, 129}));
  const Bitmap bitmap = read_bitmap(folder / "a.hdr");
  EXPECT_EQ(bitmap.stored(0, 0, 0), 1 / 8.0f);
  EXPECT_EQ(bitmap.stored(0, 0, 1), 1 / 16.0f);
  EXPECT_EQ(bitmap.stored(0, 0, 2), 1 / 4.0f);
  EXPECT_THAT(bitmap.notes,
              testing::ElementsAre(HasSubstr("EXPOSURE of 8"), HasSubstr("COLORCORR"), HasSubstr("PRIMARIES")));
}

TEST(Hdr, TurnsXyzIntoRgb) {
  const TempFolder folder;
  // Equal energy is grey; Y alone is no colour that RGB has.
  spill(folder / "a.hdr", header_with("-Y 1 +X 2", "FORMAT=32-bit_rle_xyze\n") + bytes_of_pixel({128, 128, 128, 129}) +
                              bytes_of_pixel({0, 128, 0, 129}));
  const Bitmap bitmap = read_bitmap(folder / "a.hdr");
  for (unsigned c = 0; c < 3; ++c) EXPECT_NEAR(bitmap.stored(0, 0, c), 1, 1e-6);
  EXPECT_EQ(bitmap.stored(1, 0, 0), 0) << "no negative light";
  EXPECT_GT(bitmap.stored(1, 0, 1), 1);
}

TEST(Hdr, RefusesWhatIsDamaged) {
  const TempFolder folder;
  const auto sentence = [&](const std::string& bytes) {
    spill(folder / "a.hdr", bytes);
    return error_of([&] { read_bitmap(folder / "a.hdr"); });
  };
  EXPECT_THAT(sentence("#?RADIANCE\n"), HasSubstr("ends inside its header"));
  EXPECT_THAT(sentence("#?RADIANCE\n" + std::string(10000, 'x')), HasSubstr("more than 4096 bytes"));
  std::string many = "#?RADIANCE\n";
  for (int i = 0; i < 5000; ++i) many += "x\n";
  EXPECT_THAT(sentence(many), HasSubstr("more than 4096 lines"));
  for (const char* size :
       {"-Y 2", "Y 2 +X 2", "-Y 2 +Y 2", "-Y 0 +X 2", "-Y -2 +X 2", "-Y 2 +X 2 more", "-Y 2.5 +X 2", ""})
    EXPECT_THAT(sentence(header_with(size)), HasSubstr("expected something like")) << size;
  EXPECT_THAT(sentence(header_with("-Y 100000 +X 2")), HasSubstr("2x100000 pixels"));
  EXPECT_THAT(sentence(header_with("-Y 60000 +X 60000")), HasSubstr("make it smaller"));
  EXPECT_THAT(sentence(header_with("-Y 60000 +X 1000")), HasSubstr("truncated")) << "before 720 MB are spent";
  EXPECT_THAT(sentence(header_with("-Y 1 +X 1", "FORMAT=xyz\n") + "1234"), HasSubstr("FORMAT is \"xyz\""));
  EXPECT_THAT(sentence(header_with("-Y 1 +X 1", "EXPOSURE=0\n") + "1234"),
              HasSubstr("EXPOSURE is \"0\"; expected a number above 0"));
  EXPECT_THAT(sentence(header_with("-Y 1 +X 1", "EXPOSURE=1e-300\n") + "\xff\xff\xff\xff"), HasSubstr("not finite"));
  EXPECT_THAT(sentence(header_with("-Y 1 +X 9") + std::string("\x02\x02\x00\x0a", 4)),
              HasSubstr("a line of 10 pixels where the header says 9"));
  EXPECT_THAT(sentence(header_with("-Y 1 +X 9") + std::string("\x02\x02\x00\x09\x8a\x01", 6)),
              HasSubstr("a run of 10 pixels"));
  EXPECT_THAT(sentence(header_with("-Y 1 +X 9") + std::string("\x02\x02\x00\x09\x00\x01", 6)),
              HasSubstr("a run of 0 pixels"));
}

}  // namespace
}  // namespace etendue
