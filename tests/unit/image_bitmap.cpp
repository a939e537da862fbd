/// Pictures of scenes: PNG and EXR as stored, and what all kinds have in common.

#include <cmath>
#include <cstring>
#include <functional>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <half.h>
#include <png.h>

#include "image/bitmap.h"
#include "image_testing.h"

namespace etendue {
namespace {

using testing::HasSubstr;
using testing_image::error_of;
using testing_image::slurp;
using testing_image::spill;
using testing_image::TempFolder;

std::vector<int> codes_of(const Bitmap& bitmap) {
  std::vector<int> codes;
  for (const std::byte code : bitmap.texels) codes.push_back(std::to_integer<int>(code));
  return codes;
}

struct PngKind {
  int color_type = PNG_COLOR_TYPE_RGB;
  int bits = 8;
  bool interlaced = false;
};

/// Writes rows of packed samples; `extra` may add chunks.
void write_png_kind(const std::string& path, png_uint_32 width, png_uint_32 height, const PngKind& kind,
                    std::vector<png_byte> bytes, const std::function<void(png_structp, png_infop)>& extra = {}) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, width, height, kind.bits, kind.color_type,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (extra) extra(png, info);
  png_write_info(png, info);
  const std::size_t stride = bytes.size() / height;
  std::vector<png_bytep> rows;
  for (png_uint_32 y = 0; y < height; ++y) rows.push_back(bytes.data() + y * stride);
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

TEST(BitmapPng, KeepsEightBitCodes) {
  const TempFolder folder;
  const struct {
    int type;
    std::uint32_t channels;
  } kinds[] = {
      {PNG_COLOR_TYPE_GRAY, 1}, {PNG_COLOR_TYPE_GRAY_ALPHA, 2}, {PNG_COLOR_TYPE_RGB, 3}, {PNG_COLOR_TYPE_RGBA, 4}};
  for (const auto& [type, channels] : kinds) {
    for (const bool interlaced : {false, true}) {
      std::vector<png_byte> bytes;
      std::vector<int> expected;
      for (std::uint32_t i = 0; i < 11 * 7 * channels; ++i) {
        bytes.push_back(static_cast<png_byte>(i * 37));
        expected.push_back(bytes.back());
      }
      write_png_kind(folder / "a.png", 11, 7, {type, 8, interlaced}, bytes);
      const Bitmap bitmap = read_bitmap(folder / "a.png");
      EXPECT_EQ(bitmap.width, 11u);
      EXPECT_EQ(bitmap.height, 7u);
      EXPECT_EQ(bitmap.channels, channels);
      EXPECT_EQ(bitmap.format, BitmapFormat::u8);
      EXPECT_EQ(bitmap.color_space, ColorSpace::srgb);
      EXPECT_EQ(codes_of(bitmap), expected) << "type " << type << (interlaced ? ", interlaced" : "");
      EXPECT_EQ(bitmap.stored(10, 6, channels - 1), static_cast<float>(expected.back()) / 255.0f);
      EXPECT_TRUE(bitmap.notes.empty());
    }
  }
}

TEST(BitmapPng, ExpandsPalettesShortCodesAndTransparentColors) {
  const TempFolder folder;
  png_color palette[] = {{1, 2, 3}, {250, 251, 252}};
  const auto with_palette = [&](png_structp png, png_infop info) { png_set_PLTE(png, info, palette, 2); };
  // One row of 8 pixels of one bit each: 0b01000001.
  write_png_kind(folder / "palette.png", 8, 1, {PNG_COLOR_TYPE_PALETTE, 1, false}, {0x41}, with_palette);
  Bitmap bitmap = read_bitmap(folder / "palette.png");
  EXPECT_EQ(bitmap.channels, 3u);
  EXPECT_EQ(bitmap.stored(1, 0, 2), 252 / 255.0f);
  EXPECT_EQ(bitmap.stored(6, 0, 0), 1 / 255.0f);

  png_byte alphas[] = {7};
  write_png_kind(folder / "clear.png", 8, 1, {PNG_COLOR_TYPE_PALETTE, 1, false}, {0x41},
                 [&](png_structp png, png_infop info) {
                   with_palette(png, info);
                   png_set_tRNS(png, info, alphas, 1, nullptr);
                 });
  bitmap = read_bitmap(folder / "clear.png");
  EXPECT_EQ(bitmap.channels, 4u);
  EXPECT_EQ(bitmap.stored(0, 0, 3), 7 / 255.0f);
  EXPECT_EQ(bitmap.stored(1, 0, 3), 1.0f);

  write_png_kind(folder / "short.png", 2, 1, {PNG_COLOR_TYPE_GRAY, 4, false}, {0x3f});
  EXPECT_EQ(codes_of(read_bitmap(folder / "short.png")), (std::vector<int>{3 * 17, 255}));

  write_png_kind(folder / "key.png", 2, 1, {PNG_COLOR_TYPE_GRAY, 8, false}, {9, 10},
                 [](png_structp png, png_infop info) {
                   png_color_16 key{};
                   key.gray = 10;
                   png_set_tRNS(png, info, nullptr, 0, &key);
                 });
  EXPECT_EQ(codes_of(read_bitmap(folder / "key.png")), (std::vector<int>{9, 255, 10, 0}));
}

TEST(BitmapPng, KeepsSixteenBits) {
  const TempFolder folder;
  for (const bool interlaced : {false, true}) {
    std::vector<png_byte> bytes;
    for (unsigned i = 0; i < 5 * 9 * 4; ++i) {
      const unsigned code = 331 * i + 5;
      bytes.insert(bytes.end(), {static_cast<png_byte>(code >> 8), static_cast<png_byte>(code)});
    }
    write_png_kind(folder / "a.png", 5, 9, {PNG_COLOR_TYPE_RGBA, 16, interlaced}, bytes);
    const Bitmap bitmap = read_bitmap(folder / "a.png");
    EXPECT_EQ(bitmap.format, BitmapFormat::f32);
    EXPECT_EQ(bitmap.color_space, ColorSpace::srgb);
    for (unsigned i = 0; i < 5 * 9 * 4; ++i) {
      ASSERT_EQ(bitmap.stored(i / 4 % 5, i / 20, i % 4), static_cast<float>(331 * i + 5) / 65535.0f) << i;
    }
  }
}

TEST(BitmapPng, SaysWhatIsNotFollowed) {
  const TempFolder folder;
  const auto notes_with_gamma = [&](double gamma) {
    write_png_kind(folder / "a.png", 1, 1, {PNG_COLOR_TYPE_GRAY, 8, false}, {99},
                   [&](png_structp png, png_infop info) { png_set_gAMA(png, info, gamma); });
    return read_bitmap(folder / "a.png").notes;
  };
  EXPECT_THAT(notes_with_gamma(1.0), testing::ElementsAre(HasSubstr("a.png: its gAMA of 1 is ignored")));
  EXPECT_TRUE(notes_with_gamma(0.45455).empty());
}

TEST(BitmapPng, RefusesEveryTruncationAndEveryChangedByte) {
  const TempFolder folder;
  std::vector<png_byte> bytes(5 * 4 * 3, 77);
  write_png_kind(folder / "a.png", 5, 4, {PNG_COLOR_TYPE_RGB, 8, true}, bytes);
  const std::string whole = slurp(folder / "a.png");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    spill(folder / "b.png", whole.substr(0, i));
    EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.png"); }), HasSubstr("b.png: "));
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x10);
    spill(folder / "b.png", changed);
    EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.png"); }), HasSubstr("b.png: "));
  }
}

/// A value of channel `c` at (x, y) that halves hold exactly.
float value_at(int x, int y, std::size_t c) {
  return static_cast<float>(64 * static_cast<int>(c) + 8 * y + x) / 4.0f;
}

/// An EXR file in which every channel holds value_at of its pixel and its index.
void write_exr_kind(const std::string& path, Imf::Header header,
                    const std::vector<std::pair<std::string, Imf::PixelType>>& channels, bool tiled = false) {
  const Imath::Box2i window = header.dataWindow();
  const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
  std::vector<std::vector<char>> values;
  Imf::FrameBuffer buffer;
  for (const auto& [name, type] : channels) {
    const std::size_t size = type == Imf::HALF ? 2 : 4;
    std::vector<char>& bytes = values.emplace_back(size * static_cast<std::size_t>(width * height));
    for (int i = 0; i < width * height; ++i) {
      const float value = value_at(i % width, i / width, values.size() - 1);
      const half small(value);
      const auto whole = static_cast<unsigned>(value * 4);
      const void* from = type == Imf::HALF   ? static_cast<const void*>(&small)
                         : type == Imf::UINT ? static_cast<const void*>(&whole)
                                             : static_cast<const void*>(&value);
      std::memcpy(bytes.data() + static_cast<std::size_t>(i) * size, from, size);
    }
    header.channels().insert(name, Imf::Channel(type));
    buffer.insert(name, Imf::Slice::Make(type, bytes.data(), window, size, size * static_cast<std::size_t>(width)));
  }
  if (tiled) {
    header.setTileDescription(Imf::TileDescription(4, 4));
    Imf::TiledOutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  } else {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  }
}

void expect_values(const Bitmap& bitmap, const std::vector<std::size_t>& channels) {
  ASSERT_EQ(bitmap.channels, channels.size());
  for (std::uint32_t y = 0; y < bitmap.height; ++y) {
    for (std::uint32_t x = 0; x < bitmap.width; ++x) {
      for (std::uint32_t c = 0; c < bitmap.channels; ++c) {
        ASSERT_EQ(bitmap.stored(x, y, c), value_at(static_cast<int>(x), static_cast<int>(y), channels[c]));
      }
    }
  }
}

TEST(BitmapExr, KeepsHalvesAndFloats) {
  const TempFolder folder;
  for (const bool tiled : {false, true}) {
    write_exr_kind(folder / "a.exr", Imf::Header(7, 5),
                   {{"A", Imf::HALF}, {"B", Imf::HALF}, {"G", Imf::HALF}, {"R", Imf::HALF}}, tiled);
    Bitmap bitmap = read_bitmap(folder / "a.exr");
    EXPECT_EQ(bitmap.format, BitmapFormat::f16);
    EXPECT_EQ(bitmap.color_space, ColorSpace::linear);
    expect_values(bitmap, {3, 2, 1, 0});
    write_exr_kind(folder / "a.exr", Imf::Header(7, 5),
                   {{"B", Imf::FLOAT}, {"G", Imf::HALF}, {"R", Imf::FLOAT}, {"Z", Imf::FLOAT}}, tiled);
    bitmap = read_bitmap(folder / "a.exr");
    EXPECT_EQ(bitmap.format, BitmapFormat::f32);
    expect_values(bitmap, {2, 1, 0});
  }
  write_exr_kind(folder / "a.exr", Imf::Header(3, 2), {{"A", Imf::FLOAT}, {"Y", Imf::FLOAT}});
  expect_values(read_bitmap(folder / "a.exr"), {1, 0});
}

TEST(BitmapExr, TakesIntegersAsTheyAre) {
  const TempFolder folder;
  write_exr_kind(folder / "a.exr", Imf::Header(3, 2), {{"Y", Imf::UINT}});
  const Bitmap bitmap = read_bitmap(folder / "a.exr");
  EXPECT_EQ(bitmap.stored(2, 1, 0), 4 * value_at(2, 1, 0));
  EXPECT_THAT(bitmap.notes, testing::ElementsAre(HasSubstr("integers")));
}

TEST(BitmapExr, TakesTheDataWindowAndSaysSo) {
  const TempFolder folder;
  write_exr_kind(folder / "a.exr", Imf::Header(Imath::Box2i({0, 0}, {99, 99}), Imath::Box2i({-3, 4}, {3, 6})),
                 {{"Y", Imf::HALF}});
  const Bitmap bitmap = read_bitmap(folder / "a.exr");
  EXPECT_EQ(bitmap.width, 7u);
  EXPECT_EQ(bitmap.height, 3u);
  expect_values(bitmap, {0});
  EXPECT_THAT(bitmap.notes, testing::ElementsAre(HasSubstr("data window")));
}

TEST(BitmapExr, FindsLayers) {
  const TempFolder folder;
  const std::vector<std::pair<std::string, Imf::PixelType>> sky = {
      {"sky.B", Imf::HALF}, {"sky.G", Imf::HALF}, {"sky.R", Imf::HALF}};
  write_exr_kind(folder / "a.exr", Imf::Header(3, 2), sky);
  Bitmap bitmap = read_bitmap(folder / "a.exr");
  expect_values(bitmap, {2, 1, 0});
  EXPECT_THAT(bitmap.notes, testing::ElementsAre(HasSubstr("only layer, \"sky\"")));

  auto both = sky;
  both.insert(both.begin(), {"sea.Y", Imf::HALF});
  write_exr_kind(folder / "a.exr", Imf::Header(3, 2), both);
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.exr"); }), HasSubstr("layers \"sea\", \"sky\"; name one"));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.exr", {.layer = "moon"}); }),
              HasSubstr("no picture in a layer \"moon\""));
  expect_values(read_bitmap(folder / "a.exr", {.layer = "sea"}), {0});
  expect_values(read_bitmap(folder / "a.exr", {.layer = "sky"}), {3, 2, 1});

  write_exr_kind(folder / "a.exr", Imf::Header(3, 2), {{"Z", Imf::FLOAT}});
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.exr"); }), HasSubstr("neither the channels R, G and B nor"));
}

TEST(BitmapExr, RefusesTruncations) {
  const TempFolder folder;
  write_exr_kind(folder / "a.exr", Imf::Header(3, 2), {{"Y", Imf::HALF}});
  const std::string whole = slurp(folder / "a.exr");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    spill(folder / "b.exr", whole.substr(0, i));
    EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.exr"); }), HasSubstr("b.exr: "));
  }
}

TEST(Bitmap, NamesWhatIsNoPicture) {
  const TempFolder folder;
  spill(folder / "a.png", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n");
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "a.png"); }), HasSubstr("Git LFS pointer"));
  spill(folder / "b.png", "GIF89a");
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "b.png"); }),
              HasSubstr("not a PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR"));
  spill(folder / "c.png", "");
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "c.png"); }), HasSubstr("is empty"));
  EXPECT_THAT(error_of([&] { read_bitmap(folder / "none.png"); }), HasSubstr("none.png: cannot open it"));
  EXPECT_THAT(error_of([&] { read_bitmap(folder.path()); }), HasSubstr("cannot read it"));
}

TEST(Bitmap, ClearsNegativeValues) {
  Bitmap bitmap{.width = 2, .height = 1, .channels = 2, .format = BitmapFormat::f16};
  // 1, -1, -0, NaN
  for (const unsigned half : {0x3c00u, 0xbc00u, 0x8000u, 0xfe00u}) {
    bitmap.texels.push_back(static_cast<std::byte>(half & 255u));
    bitmap.texels.push_back(static_cast<std::byte>(half >> 8));
  }
  EXPECT_EQ(clear_negative_values(bitmap), 1u);
  EXPECT_EQ(bitmap.stored(0, 0, 0), 1.0f);
  EXPECT_EQ(bitmap.stored(0, 0, 1), 0.0f);
  EXPECT_TRUE(std::isnan(bitmap.stored(1, 0, 1)));
}

TEST(Bitmap, UndoesTheCurveOfSrgb) {
  EXPECT_EQ(linear_from_srgb(0), 0);
  EXPECT_EQ(linear_from_srgb(1), 1);
  EXPECT_NEAR(linear_from_srgb(128 / 255.0), 0.2158605, 1e-7);
  EXPECT_NEAR(linear_from_srgb(0.04), 0.04 / 12.92, 1e-15);
}

/// A BMP file of 3 x 2 pixels with the given bits and rows as they are stored.
std::string bmp(int bits, int height, const std::string& palette, const std::string& rows) {
  const auto u32 = [](std::uint32_t v) {
    return std::string{static_cast<char>(v & 255), static_cast<char>(v >> 8 & 255), static_cast<char>(v >> 16 & 255),
                       static_cast<char>(v >> 24)};
  };
  const auto offset = static_cast<std::uint32_t>(54 + palette.size());
  return "BM" + u32(offset + static_cast<std::uint32_t>(rows.size())) + u32(0) + u32(offset) + u32(40) + u32(3) +
         u32(static_cast<std::uint32_t>(height)) + u32(1u | static_cast<std::uint32_t>(bits) << 16) + u32(0) + u32(0) +
         u32(0) + u32(0) + u32(static_cast<std::uint32_t>(palette.size() / 4)) + u32(0) + palette + rows;
}

TEST(Bmp, RowsComeLastFirstAndColoursBlueFirst) {
  const TempFolder folder;
  const std::vector<int> wanted = {1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14, 15, 16, 17, 18, 19};
  using namespace std::string_literals;
  const std::string lower = "\x0d\x0c\x0b\x10\x0f\x0e\x13\x12\x11\0\0\0"s, upper = "\3\2\1\6\5\4\x09\x08\x07\0\0\0"s;
  const std::vector<std::string> files = {
      bmp(24, 2, "", lower + upper), bmp(24, -2, "", upper + lower),
      bmp(32, -2, "", "\3\2\1\0\6\5\4\0\x09\x08\x07\0\x0d\x0c\x0b\0\x10\x0f\x0e\0\x13\x12\x11\0"s),
      bmp(8, -2, "\3\2\1\0\6\5\4\0\x09\x08\x07\0\x0d\x0c\x0b\0\x10\x0f\x0e\0\x13\x12\x11\0"s, "\0\1\2\0\3\4\5\0"s)};
  for (const std::string& file : files) {
    const std::string path = folder / "a.bmp";
    spill(path, file);
    const Bitmap bitmap = read_bitmap(path);
    EXPECT_EQ(bitmap.width, 3u);
    EXPECT_EQ(bitmap.height, 2u);
    EXPECT_EQ(bitmap.color_space, ColorSpace::srgb);
    EXPECT_EQ(codes_of(bitmap), wanted);
  }
  const std::string path = folder / "b.bmp";
  spill(path, files[0].substr(0, files[0].size() - 1));
  EXPECT_THAT(error_of([&] { read_bitmap(path); }), HasSubstr("it ends before its last pixel"));
  spill(path, bmp(8, 2, "\0\0\0\0"s, "\1\0\0\0\0\0\0\0"s));
  EXPECT_THAT(error_of([&] { read_bitmap(path); }), HasSubstr("a pixel has colour 1 of a palette of 1"));
}

}  // namespace
}  // namespace etendue
