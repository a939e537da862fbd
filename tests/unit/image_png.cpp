/// PNG pictures: sRGB codes, kinds of PNG, damaged files.

#include <cmath>
#include <cstdio>
#include <limits>

#include <gtest/gtest.h>
#include <png.h>

#include "image_testing.h"

namespace etendue {
namespace {

using testing_image::error_of;
using testing_image::slurp;
using testing_image::spill;
using testing_image::TempFolder;

Image grey_image(const std::vector<float>& values) {
  Image image;
  image.width = static_cast<std::uint32_t>(values.size());
  image.height = 1;
  for (const float value : values) image.pixels.emplace_back(value);
  return image;
}

/// The codes of the first channel, as libpng's own reader finds them.
std::vector<int> codes_in(const std::string& path) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&png, path.c_str()), 0) << png.message;
  EXPECT_EQ(png.format, static_cast<png_uint_32>(PNG_FORMAT_RGB));
  png.format = PNG_FORMAT_RGB;
  std::vector<png_byte> bytes(PNG_IMAGE_SIZE(png));
  EXPECT_NE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr), 0) << png.message;
  std::vector<int> codes;
  for (std::size_t i = 0; i < bytes.size(); i += 3) codes.push_back(bytes[i]);
  return codes;
}

void write_with_libpng(const std::string& path, png_uint_32 format, png_uint_32 width, png_uint_32 height,
                       const void* pixels, png_uint_32 colors = 0, const void* map = nullptr) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.format = format;
  png.width = width;
  png.height = height;
  png.colormap_entries = colors;
  ASSERT_NE(png_image_write_to_file(&png, path.c_str(), 0, pixels, 0, map), 0) << png.message;
}

/// IEC 61966-2-1, written down a second time.
double linear_of(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

TEST(Png, EncodesKnownValues) {
  const TempFolder folder;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  // Published pairs: middle grey 0.18 is code 118, half the light is 188, code 128 is 0.2158605, the linear part ends
  // at 0.0031308.
  write_png(folder / "a.png", grey_image({0.0f, 1.0f, 0.5f, 0.18f, 0.2158605f, 0.0031308f, 0.001f, -1.0f, 2.0f,
                                          kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}));
  EXPECT_EQ(codes_in(folder / "a.png"), (std::vector<int>{0, 255, 188, 118, 128, 10, 3, 0, 255, 255, 0, 0}));
}

TEST(Png, RoundsToTheNearestCode) {
  const TempFolder folder;
  // Just below and just above each midpoint between two codes.
  std::vector<float> values;
  std::vector<int> expected;
  for (int code = 0; code < 255; ++code) {
    const double middle = linear_of((code + 0.5) / 255.0);
    values.insert(values.end(), {static_cast<float>(middle * (1 - 1e-6)), static_cast<float>(middle * (1 + 1e-6))});
    expected.insert(expected.end(), {code, code + 1});
  }
  write_png(folder / "a.png", grey_image(values));
  EXPECT_EQ(codes_in(folder / "a.png"), expected);
}

TEST(Png, ReadsBackEveryCode) {
  const TempFolder folder;
  constexpr int kCodes = 256;
  std::vector<float> values;
  values.reserve(kCodes);
  for (int code = 0; code < kCodes; ++code) values.push_back(static_cast<float>(linear_of(code / 255.0)));
  write_png(folder / "a.png", grey_image(values));
  const Image back = read_image(folder / "a.png");
  ASSERT_EQ(back.pixels.size(), 256u);
  for (std::size_t i = 0; i < 256; ++i) EXPECT_EQ(back.pixels[i], glm::vec3(values[i])) << i;
  EXPECT_FALSE(back.has_statistics());
}

TEST(Png, KeepsRowsColumnsAndChannelsApart) {
  const TempFolder folder;
  Image image;
  image.width = 3;
  image.height = 2;
  for (int i = 0; i < 6; ++i) {
    image.pixels.emplace_back(linear_of((10 * i) / 255.0), linear_of((10 * i + 1) / 255.0),
                              linear_of((10 * i + 2) / 255.0));
  }
  image.metadata = {{"scene", "a box.xml"}, {"integrator", "ünïcode"}, {"not a keyword", "x"}};
  write_png(folder / "a.png", image);
  const Image back = read_image(folder / "a.png");
  EXPECT_EQ(back.pixels, image.pixels);
  EXPECT_EQ(back.metadata, (Metadata{{"scene", "a box.xml"}, {"integrator", "ünïcode"}}));
  EXPECT_NE(slurp(folder / "a.png").find("sRGB"), std::string::npos);
  EXPECT_EQ(folder.files(), 1u);
}

TEST(Png, ReadsOtherKinds) {
  const TempFolder folder;
  const auto value = [](int code) { return glm::vec3(static_cast<float>(linear_of(code / 255.0))); };
  const std::vector<png_byte> grey = {0, 50, 100, 255};
  write_with_libpng(folder / "grey.png", PNG_FORMAT_GRAY, 2, 2, grey.data());
  EXPECT_EQ(read_image(folder / "grey.png").pixels[1], value(50));

  const std::vector<png_byte> rgba = {200, 200, 200, 0, 50, 50, 50, 128};
  write_with_libpng(folder / "rgba.png", PNG_FORMAT_RGBA, 2, 1, rgba.data());
  EXPECT_EQ(read_image(folder / "rgba.png").pixels[1], value(50)) << "alpha is left out, not multiplied";

  const std::vector<png_byte> index = {0, 1, 1, 0};
  const std::vector<png_byte> map = {9, 9, 9, 77, 77, 77};
  write_with_libpng(folder / "palette.png", PNG_FORMAT_RGB_COLORMAP, 4, 1, index.data(), 2, map.data());
  EXPECT_EQ(read_image(folder / "palette.png").pixels[1], value(77));
  EXPECT_EQ(read_image(folder / "palette.png").pixels[3], value(9));
}

/// 16 bits, interlaced: codes 257 · i + 13.
void write_deep_interlaced(const std::string& path, std::uint32_t width, std::uint32_t height) {
  std::vector<png_byte> bytes;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const std::uint32_t code = 257 * i + 13;
    for (int c = 0; c < 3; ++c)
      bytes.insert(bytes.end(), {static_cast<png_byte>(code >> 8), static_cast<png_byte>(code)});
  }
  std::vector<png_bytep> rows;
  for (std::uint32_t y = 0; y < height; ++y) rows.push_back(bytes.data() + std::size_t{6} * y * width);
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, width, height, 16, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_ADAM7, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

TEST(Png, ReadsSixteenBitsInterlaced) {
  const TempFolder folder;
  write_deep_interlaced(folder / "a.png", 11, 9);
  const Image image = read_image(folder / "a.png");
  for (std::size_t i = 0; i < 99; ++i) {
    ASSERT_EQ(image.pixels[i], glm::vec3(static_cast<float>(linear_of(static_cast<double>(257 * i + 13) / 65535.0))))
        << i;
  }
}

TEST(Png, RefusesEveryTruncation) {
  const TempFolder folder;
  write_deep_interlaced(folder / "a.png", 5, 5);
  const std::string whole = slurp(folder / "a.png");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    spill(folder / "b.png", whole.substr(0, length));
    const std::string sentence = error_of([&] { read_image(folder / "b.png"); });
    EXPECT_EQ(sentence.find(folder / "b.png"), 0u) << sentence;
  }
}

TEST(Png, RefusesEveryChangedByte) {
  const TempFolder folder;
  Image image = grey_image({0.1f, 0.2f, 0.9f});
  image.metadata = {{"scene", "box"}};
  write_png(folder / "a.png", image);
  const std::string whole = slurp(folder / "a.png");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x10);
    spill(folder / "b.png", bytes);
    error_of([&] { read_image(folder / "b.png"); });
  }
}

TEST(Png, RefusesSizesTheFileCannotHold) {
  // Signature, a header that announces 8000 x 8000 pixels of 16-bit RGBA with a right checksum, and one empty data
  // chunk.
  const TempFolder folder;
  const unsigned char bytes[] = {0x89, 'P', 'N', 'G',  13,   10, 26, 10,   0,    0,  0, 13, 'I', 'H', 'D',
                                 'R',  0,   0,   0x1f, 0x40, 0,  0,  0x1f, 0x40, 16, 6, 0,  0,   0};
  std::string file(reinterpret_cast<const char*>(bytes), sizeof bytes);
  std::uint32_t crc = 0xffffffffu;
  for (std::size_t i = 12; i < file.size(); ++i) {
    crc ^= static_cast<unsigned char>(file[i]);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  crc = ~crc;
  for (int shift = 24; shift >= 0; shift -= 8) file += static_cast<char>(crc >> shift);
  file += std::string("\0\0\0\0IDAT\x35\xaf\x06\x1e", 12);
  spill(folder / "a.png", file);
  const std::string sentence = error_of([&] { read_image(folder / "a.png"); });
  EXPECT_NE(sentence.find("512000000 bytes of pixels"), std::string::npos) << sentence;
}

TEST(Png, RefusesChunksTheFileCannotHold) {
  // Found by fuzz_image_png: a text of 1.7 GiB in a file of 212 bytes. libpng would reserve it and fill it with zeros.
  const TempFolder folder;
  write_png(folder / "a.png", grey_image({0.1f, 0.2f, 0.9f}));
  std::string bytes = slurp(folder / "a.png");
  bytes.insert(33, std::string("\x68\0\0\x0biTXtscene\0\0\0\0\0x", 19));  // after the header
  spill(folder / "b.png", bytes);
  const std::string sentence = error_of([&] { read_image(folder / "b.png"); });
  EXPECT_NE(sentence.find("longer than the file"), std::string::npos) << sentence;
}

TEST(Png, RefusesImagesThatDoNotFitTogether) {
  const TempFolder folder;
  Image image = grey_image({0.5f, 0.5f});
  image.pixels.pop_back();
  error_of([&] { write_png(folder / "a.png", image); });
  error_of([&] { write_png(folder / "a.png", Image{}); });
  error_of([&] { write_png(folder / "missing/a.png", grey_image({0.5f})); });
  EXPECT_EQ(folder.files(), 0u);
}

}  // namespace
}  // namespace etendue
