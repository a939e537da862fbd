/// PNG pictures: 8-bit sRGB out, anything libpng understands in.

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <vector>

#include <fmt/format.h>
#include <png.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "image/exr_io.h"
#include "image/files.h"

namespace etendue {
namespace {

/// What libpng's callbacks share with us. libpng leaves by longjmp, so functions that call it hold nothing with a
/// destructor.
struct PngState {
  std::vector<std::byte> output;
  std::span<const std::byte> input;
  std::size_t position = 0;
  std::array<char, 256> message{};
};

extern "C" {

[[noreturn]] static void on_png_error(png_structp png, png_const_charp message) {
  auto* state = static_cast<PngState*>(png_get_error_ptr(png));
  std::strncpy(state->message.data(), message, state->message.size() - 1);
  png_longjmp(png, 1);
}

static void on_png_warning(png_structp, png_const_charp) {}

static void write_png_bytes(png_structp png, png_bytep bytes, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  bool enough = true;
  try {
    const auto* begin = reinterpret_cast<const std::byte*>(bytes);
    state->output.insert(state->output.end(), begin, begin + count);
  } catch (const std::exception&) {
    enough = false;
  }
  if (!enough) png_error(png, "out of memory");
}

static void flush_png(png_structp) {}

}  // extern "C"

/// IEC 61966-2-1, clamped to [0,1]; NaN becomes 0. In double; 255 times it is rounded to the nearest integer, halves
/// up.
png_byte encode_srgb(float linear) {
  const double x = linear > 0.0f ? std::min(static_cast<double>(linear), 1.0) : 0.0;
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
  return static_cast<png_byte>(std::floor(255.0 * encoded + 0.5));
}

/// Keywords are 1 to 79 printable Latin-1 characters without blanks at the ends or in pairs; here plain ASCII without
/// blanks.
bool is_png_keyword(const std::string& key) {
  return !key.empty() && key.size() <= 79 &&
         std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c <= '~'; });
}

/// Returns false when libpng gave up; state.message says why.
bool encode(png_structp png, png_infop info, PngState& state, std::uint32_t width, std::uint32_t height,
            png_bytepp rows, png_textp texts, int text_count) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &state, write_png_bytes, flush_png);
  png_set_user_limits(png, kMaxImageSide, kMaxImageSide);
  png_set_IHDR(png, info, width, height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
  if (text_count > 0) png_set_text(png, info, texts, text_count);
  png_write_info(png, info);
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  return true;
}

}  // namespace

void write_png(const std::string& path, const Image& image) {
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  if (count == 0 || image.pixels.size() != count) {
    throw Error(ExitCode::file_error, fmt::format("{}: cannot write an image of {}x{} pixels that holds {}", path,
                                                  image.width, image.height, image.pixels.size()));
  }
  std::vector<png_byte> encoded(3 * count);
  parallel_for(count, 8192, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      for (int c = 0; c < 3; ++c) encoded[3 * i + c] = encode_srgb(image.pixels[i][c]);
    }
  });
  std::vector<png_bytep> rows(image.height);
  for (std::uint32_t y = 0; y < image.height; ++y) rows[y] = encoded.data() + std::size_t{3} * y * image.width;
  // International text: values are UTF-8. libpng does not change what the non-const pointers point to.
  std::vector<png_text> texts;
  for (const auto& [key, value] : image.metadata) {
    if (!is_png_keyword(key)) continue;
    png_text text{};
    text.compression = PNG_ITXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(key.c_str());
    text.text = const_cast<char*>(value.c_str());
    texts.push_back(text);
  }
  PngState state;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, on_png_error, on_png_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool encodable = info != nullptr && encode(png, info, state, image.width, image.height, rows.data(),
                                                   texts.data(), static_cast<int>(texts.size()));
  png_destroy_write_struct(&png, &info);
  if (!encodable)
    throw Error(ExitCode::file_error, fmt::format("{}: cannot be encoded as PNG: {}", path, state.message.data()));
  write_file_atomically(path, state.output);
}

}  // namespace etendue
