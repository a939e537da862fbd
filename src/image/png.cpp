/// PNG pictures: writes 8-bit sRGB, reads anything that libpng understands.

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <png.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "image/bitmap_file.h"
#include "image/decode.h"
#include "image/files.h"

namespace etendue {
namespace {

/// State shared with libpng's callbacks. libpng reports errors by longjmp, so functions that call it must not hold
/// objects with destructors.
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

static void read_png_bytes(png_structp png, png_bytep target, std::size_t count) {
  auto* state = static_cast<PngState*>(png_get_io_ptr(png));
  if (count > state->input.size() - state->position) png_error(png, "the file ends too early");
  std::memcpy(target, state->input.data() + state->position, count);
  state->position += count;
}

}  // extern "C"

/// IEC 61966-2-1, clamped to [0,1]; NaN becomes 0. In double; 255 times it is rounded to the nearest integer, halves
/// up.
png_byte encode_srgb(double linear) {
  const double x = linear > 0.0 ? std::min(linear, 1.0) : 0.0;
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
  return static_cast<png_byte>(std::floor(255.0 * encoded + 0.5));
}

/// Keywords are 1 to 79 printable Latin-1 characters without blanks at the ends or in pairs; here plain ASCII without
/// blanks.
bool is_png_keyword(const std::string& key) {
  return !key.empty() && key.size() <= 79 &&
         std::all_of(key.begin(), key.end(), [](char c) { return c > ' ' && c <= '~'; });
}

/// Returns false if libpng has failed; state.message says why.
bool encode(png_structp png, png_infop info, PngState& state, const Image& image, png_bytepp rows, bool alpha,
            png_textp texts, int text_count) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &state, write_png_bytes, flush_png);
  png_set_user_limits(png, kMaxImageSide, kMaxImageSide);
  png_set_IHDR(png, info, image.width, image.height, 8, alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_RELATIVE);
  if (text_count > 0) png_set_text(png, info, texts, text_count);
  png_write_info(png, info);
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  return true;
}

/// Codes as stored, of 8 or 16 bits in this machine's byte order, whatever they mean.
bool encode_codes(png_structp png, png_infop info, PngState& state, const Bitmap& bitmap, int bits, png_bytepp rows) {
  constexpr std::array<int, 4> kTypes = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                         PNG_COLOR_TYPE_RGB_ALPHA};
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &state, write_png_bytes, flush_png);
  png_set_user_limits(png, kMaxImageSide, kMaxImageSide);
  png_set_IHDR(png, info, bitmap.width, bitmap.height, bits, kTypes[bitmap.channels - 1], PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (bits == 16) png_set_swap(png);
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  return true;
}

/// Reads up to the pixels. Returns false when libpng gave up.
bool read_info(png_structp png, png_infop info, PngState& state) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &state, read_png_bytes);
  png_set_user_limits(png, kMaxImageSide, kMaxImageSide);
  png_set_chunk_malloc_max(png, 8u << 20);  // bounds the size of an uncompressed text
  png_set_chunk_cache_max(png, 1000);
  png_set_crc_action(png, PNG_CRC_ERROR_QUIT, PNG_CRC_ERROR_QUIT);
  png_read_info(png, info);
  return true;
}

/// Where each of `height` rows begins in bytes without gaps.
std::vector<png_bytep> row_pointers(std::vector<png_byte>& bytes, std::size_t height) {
  std::vector<png_bytep> rows;
  const std::size_t stride = bytes.size() / height;
  for (std::size_t y = 0; y < height; ++y) rows.push_back(bytes.data() + y * stride);
  return rows;
}

/// Everything becomes three 16-bit channels: palettes and greys are expanded, alpha is left out.
bool read_rows(png_structp png, png_infop info, PngState& state, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_expand_16(png);
  png_set_gray_to_rgb(png);
  png_set_strip_alpha(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != std::size_t{6} * png_get_image_width(png, info)) {
    std::strncpy(state.message.data(), "unknown pixel format", state.message.size() - 1);
    return false;
  }
  png_read_image(png, rows);
  png_read_end(png, info);
  return true;
}

/// Everything keeps its channels and becomes 8 or 16 bits: palettes and short greys are expanded, a transparent colour
/// becomes alpha. 16-bit codes come in this machine's order.
bool read_stored_rows(png_structp png, png_infop info, PngState& state, std::span<png_byte> bytes,
                      std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_expand(png);
  png_set_swap(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes) {
    std::strncpy(state.message.data(), "unknown pixel format", state.message.size() - 1);
    return false;
  }
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t begin = 0; begin < bytes.size(); begin += row_bytes) png_read_row(png, &bytes[begin], nullptr);
  }
  png_read_end(png, info);
  return true;
}

/// Linear values of the 65536 codes, IEC 61966-2-1, rounded to float32.
const std::vector<float>& srgb_decoding() {
  static const std::vector<float> table = [] {
    std::vector<float> values(65536);
    for (std::size_t code = 0; code < values.size(); ++code) {
      const double x = static_cast<double>(code) / 65535.0;
      values[code] = static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table;
}

/// Frees libpng's structures on the way out.
struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  explicit PngReader(PngState& state) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &state, on_png_error, on_png_warning);
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
    if (info == nullptr) {
      png_destroy_read_struct(&png, &info, nullptr);
      throw std::bad_alloc();
    }
  }
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
};

/// The channels and bit depth that png_set_expand will give for the file.
std::uint32_t expanded_channels(png_structp png, png_infop info) {
  const unsigned type = png_get_color_type(png, info);
  const std::uint32_t colors = (type & PNG_COLOR_MASK_COLOR) != 0 ? 3 : 1;
  const bool alpha = (type & PNG_COLOR_MASK_ALPHA) != 0 || png_get_valid(png, info, PNG_INFO_tRNS) != 0;
  return colors + (alpha ? 1 : 0);
}

void add_color_notes(png_structp png, png_infop info, const std::string& path, Bitmap& bitmap) {
  png_fixed_point gamma = 0;
  constexpr png_fixed_point kSrgbGamma = 45455, kClose = 500;
  const bool says_gamma = png_get_gAMA_fixed(png, info, &gamma) != 0 && std::abs(gamma - kSrgbGamma) > kClose;
  if (png_get_valid(png, info, PNG_INFO_sRGB) != 0) return;
  if (says_gamma) {
    bitmap.notes.push_back(
        fmt::format("{}: its gAMA of {:g} is ignored; values are taken as sRGB or as linear, as the scene says", path,
                    gamma / 100000.0));
  }
  png_charp name = nullptr;
  int method = 0;
  png_bytep profile = nullptr;
  png_uint_32 length = 0;
  if (png_get_iCCP(png, info, &name, &method, &profile, &length) != 0 &&
      std::string_view(name).find("sRGB") == std::string_view::npos)
    bitmap.notes.push_back(fmt::format("{}: its colour profile is ignored; primaries are taken as Rec. 709", path));
}

/// 16-bit codes as float32 in [0,1].
void floats_from_codes(std::span<const png_byte> codes, std::vector<std::byte>& texels) {
  for (std::size_t i = 0; i < codes.size() / 2; ++i) {
    std::uint16_t code = 0;
    std::memcpy(&code, &codes[2 * i], sizeof code);
    const float value = static_cast<float>(code) / 65535.0f;
    std::memcpy(&texels[4 * i], &value, sizeof value);
  }
}

Metadata png_metadata(png_structp png, png_infop info) {
  Metadata metadata;
  png_textp texts = nullptr;
  int count = 0;
  png_get_text(png, info, &texts, &count);
  for (int i = 0; i < count; ++i) metadata[texts[i].key] = texts[i].text != nullptr ? texts[i].text : "";
  return metadata;
}

/// Whether no chunk before the one called `last` announces more bytes than there are. libpng allocates the announced
/// size, up to 2 GiB, before it reads a chunk, and only warns about its own limit.
bool chunks_fit(std::span<const std::byte> bytes, const char* last) {
  const auto at = [&](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); };
  for (std::size_t begin = 8; bytes.size() >= begin + 8;) {
    const std::size_t length = at(begin) << 24 | at(begin + 1) << 16 | at(begin + 2) << 8 | at(begin + 3);
    if (std::memcmp(&bytes[begin + 4], last, 4) == 0) break;
    if (length > bytes.size() - begin - 8) return false;
    begin += length + 12;
  }
  return true;
}

/// Throws unless the size is within the limits and the file can hold that many pixels (deflate shrinks by at most
/// 1032).
void check_png_size(png_structp png, png_infop info, std::size_t file_size, const std::string& path) {
  const std::uint64_t width = png_get_image_width(png, info);
  const std::uint64_t height = png_get_image_height(png, info);
  if (width * height > kMaxImagePixels) {
    throw Error(ErrorKind::file,
                fmt::format("{}: has {}x{} pixels; at most {} are read", path, width, height, kMaxImagePixels));
  }
  const std::uint64_t raw = png_get_rowbytes(png, info) * height;
  if (raw / 1040 > file_size) {
    throw Error(ErrorKind::file, fmt::format("{}: announces {} bytes of pixels but has only {} bytes: it is damaged or "
                                             "truncated",
                                             path, raw, file_size));
  }
}

/// The metadata record how the values were changed, because such a picture no longer shows radiance.
Metadata with_display(Metadata metadata, const Display& display) {
  if (display.tone_map != ToneMap::none) metadata["toneMapping"] = name_of(display.tone_map);
  if (display.exposure != 0.0) metadata["exposure"] = fmt::format("{:+g}", display.exposure);
  return metadata;
}

/// The channel A, or null.
const std::vector<float>* alpha_of(const Image& image) {
  const auto found = std::ranges::find(image.channels, "A", &ImageChannel::name);
  return found != image.channels.end() ? &found->values : nullptr;
}

}  // namespace

std::vector<std::byte> encode_png(const Image& image, const Display& display, const std::string& name) {
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  if (count == 0 || image.pixels.size() != count) {
    throw Error(ErrorKind::file, fmt::format("{}: cannot write an image of {}x{} pixels that holds {}", name,
                                             image.width, image.height, image.pixels.size()));
  }
  const std::vector<float>* alpha = alpha_of(image);
  const std::size_t stride = alpha != nullptr ? 4 : 3;
  std::vector<png_byte> encoded(stride * count);
  parallel_for(count, 8192, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      // Colours of a PNG are not multiplied by alpha, those of renders are.
      const float a = alpha != nullptr ? (*alpha)[i] : 1.0f;
      const glm::vec3 color = a > 0.0f ? image.pixels[i] / a : glm::vec3(0.0f);
      const glm::dvec3 shown = tone_mapped(color, display);
      for (int c = 0; c < 3; ++c) encoded[stride * i + c] = encode_srgb(shown[c]);
      if (alpha != nullptr) encoded[stride * i + 3] = static_cast<png_byte>(std::lround(255.0f * a));
    }
  });
  std::vector<png_bytep> rows = row_pointers(encoded, image.height);
  // International text: values are UTF-8. libpng does not change what the non-const pointers point to.
  std::vector<png_text> texts;
  const Metadata metadata = with_display(image.metadata, display);
  for (const auto& [key, value] : metadata) {
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
  const bool encodable = info != nullptr && encode(png, info, state, image, rows.data(), alpha != nullptr, texts.data(),
                                                   static_cast<int>(texts.size()));
  png_destroy_write_struct(&png, &info);
  if (!encodable)
    throw Error(ErrorKind::file, fmt::format("{}: cannot be encoded as PNG: {}", name, state.message.data()));
  return std::move(state.output);
}

void write_png(const std::string& path, const Image& image, const Display& display) {
  write_file_atomically(path, encode_png(image, display, path));
}

void write_png_bitmap(const std::string& path, const Bitmap& bitmap) {
  const bool wide = bitmap.format != BitmapFormat::u8;
  std::vector<png_byte> bytes;
  if (!wide) {
    bytes.resize(bitmap.texels.size());
    std::memcpy(bytes.data(), bitmap.texels.data(), bytes.size());
  } else {
    const std::size_t numbers = std::size_t{bitmap.width} * bitmap.height * bitmap.channels;
    bytes.resize(2 * numbers);
    for (std::size_t i = 0; i < numbers; ++i) {
      const auto x = static_cast<std::uint32_t>(i / bitmap.channels % bitmap.width);
      const auto y = static_cast<std::uint32_t>(i / bitmap.channels / bitmap.width);
      const float stored = bitmap.stored(x, y, static_cast<std::uint32_t>(i % bitmap.channels));
      const double code = std::floor(65535.0 * static_cast<double>(stored) + 0.5);
      const auto rounded = static_cast<std::uint16_t>(std::clamp(code, 0.0, 65535.0));
      if (static_cast<float>(rounded) / 65535.0f != stored)
        throw Error(
            ErrorKind::file,
            fmt::format(
                "{}: floats coded by the curve of sRGB are written as 16-bit PNG, but {} is not one of its numbers",
                path, stored));
      std::memcpy(&bytes[2 * i], &rounded, sizeof rounded);
    }
  }
  std::vector<png_bytep> rows = row_pointers(bytes, bitmap.height);
  PngState state;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, on_png_error, on_png_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool encodable = info != nullptr && encode_codes(png, info, state, bitmap, wide ? 16 : 8, rows.data());
  png_destroy_write_struct(&png, &info);
  if (!encodable)
    throw Error(ErrorKind::file, fmt::format("{}: cannot be encoded as PNG: {}", path, state.message.data()));
  write_file_atomically(path, state.output);
}

bool is_png(std::span<const std::byte> bytes) {
  return bytes.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, 8) == 0;
}

PictureHeader decode_png_header(std::span<const std::byte> bytes, std::uint64_t file_size, const std::string& path) {
  PngState state;
  state.input = bytes;
  PngReader reader(state);
  if (!chunks_fit(bytes, "IDAT") || !read_info(reader.png, reader.info, state))
    throw Error(ErrorKind::file, fmt::format("{}: is a damaged PNG file, or one with very long texts", path));
  check_png_size(reader.png, reader.info, file_size, path);
  return {.width = png_get_image_width(reader.png, reader.info),
          .height = png_get_image_height(reader.png, reader.info),
          .metadata = png_metadata(reader.png, reader.info)};
}

Image decode_png(std::span<const std::byte> bytes, const std::string& path) {
  PngState state;
  state.input = bytes;
  PngReader reader(state);
  const auto damaged = [&] {
    return Error(ErrorKind::file, fmt::format("{}: is a damaged PNG file: {}", path, state.message.data()));
  };
  if (is_png(bytes) && !chunks_fit(bytes, "IEND")) {
    throw Error(ErrorKind::file, fmt::format("{}: is a damaged PNG file: a chunk is longer than the file", path));
  }
  if (!read_info(reader.png, reader.info, state)) throw damaged();
  check_png_size(reader.png, reader.info, bytes.size(), path);

  Image image;
  image.width = png_get_image_width(reader.png, reader.info);
  image.height = png_get_image_height(reader.png, reader.info);
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  std::vector<png_byte> encoded(6 * count);
  std::vector<png_bytep> rows = row_pointers(encoded, image.height);
  if (!read_rows(reader.png, reader.info, state, rows.data())) throw damaged();

  image.pixels.resize(count);
  const std::vector<float>& decoding = srgb_decoding();
  for (std::size_t i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      const png_byte* sample = &encoded[6 * i + 2 * static_cast<std::size_t>(c)];
      image.pixels[i][c] = decoding[static_cast<std::size_t>(sample[0]) << 8 | sample[1]];
    }
  }
  image.metadata = png_metadata(reader.png, reader.info);
  return image;
}

Bitmap decode_png_bitmap(std::span<const std::byte> bytes, const std::string& path) {
  PngState state;
  state.input = bytes;
  PngReader reader(state);
  const auto damaged = [&] {
    return Error(ErrorKind::file, fmt::format("{}: is a damaged PNG file: {}", path, state.message.data()));
  };
  if (is_png(bytes) && !chunks_fit(bytes, "IEND"))
    throw Error(ErrorKind::file, fmt::format("{}: is a damaged PNG file: a chunk is longer than the file", path));
  if (!read_info(reader.png, reader.info, state)) throw damaged();
  check_png_size(reader.png, reader.info, bytes.size(), path);

  const bool deep = png_get_bit_depth(reader.png, reader.info) == 16;
  Bitmap bitmap =
      make_bitmap(png_get_image_width(reader.png, reader.info), png_get_image_height(reader.png, reader.info),
                  expanded_channels(reader.png, reader.info), deep ? BitmapFormat::f32 : BitmapFormat::u8);
  bitmap.color_space = ColorSpace::srgb;
  add_color_notes(reader.png, reader.info, path, bitmap);
  std::vector<png_byte> codes(deep ? bitmap.texels.size() / 2 : 0);
  const std::span<png_byte> stored =
      deep ? std::span(codes) : std::span(reinterpret_cast<png_byte*>(bitmap.texels.data()), bitmap.texels.size());
  if (!read_stored_rows(reader.png, reader.info, state, stored, stored.size() / bitmap.height)) throw damaged();
  if (deep) floats_from_codes(codes, bitmap.texels);
  return bitmap;
}

}  // namespace etendue
