/// JPEG pictures: grey and YCbCr, sequential and progressive.

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>

#include <fmt/format.h>
// After <cstdio>, which it needs and does not include.
#include <jpeglib.h>
// After jpeglib.h, for the codes of messages.
#include <jerror.h>

#include "core/errors.h"
#include "image/decode.h"

namespace etendue {
namespace {

/// More scans than any picture needs (a progressive one has about ten); each may be only a few bytes long and yet
/// process all blocks.
constexpr int kMostScans = 200;

/// State shared with libjpeg's callbacks. libjpeg reports errors by longjmp, so functions that call it must not hold
/// objects with destructors.
struct JpegState {
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  std::jmp_buf leave;
  std::array<char, JMSG_LENGTH_MAX> message{};
  bool extra_bytes = false;  ///< meaningless bytes between segments, which are harmless
};

JpegState& state_of(j_common_ptr jpeg) {
  return *static_cast<JpegState*>(jpeg->client_data);
}

extern "C" {

[[noreturn]] static void on_jpeg_error(j_common_ptr jpeg) {
  JpegState& state = state_of(jpeg);
  jpeg->err->format_message(jpeg, state.message.data());
  std::longjmp(state.leave, 1);
}

/// After a "warning", libjpeg continues with grey in place of missing data; here that is an error.
static void on_jpeg_message(j_common_ptr jpeg, int level) {
  if (level >= 0) return;
  if (jpeg->err->msg_code == JWRN_EXTRANEOUS_DATA) {
    state_of(jpeg).extra_bytes = true;
  } else {
    on_jpeg_error(jpeg);
  }
}

static void on_jpeg_progress(j_common_ptr jpeg) {
  if (reinterpret_cast<j_decompress_ptr>(jpeg)->input_scan_number <= kMostScans) return;
  JpegState& state = state_of(jpeg);
  std::snprintf(state.message.data(), state.message.size(), "it has more than %d scans", kMostScans);
  std::longjmp(state.leave, 1);
}

}  // extern "C"

/// Frees libjpeg's structures on the way out.
struct JpegReader {
  jpeg_decompress_struct jpeg{};
  JpegReader() = default;
  ~JpegReader() { jpeg_destroy_decompress(&jpeg); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
};

/// Reads up to the pixels. Returns false if libjpeg has failed; state.message says why.
bool read_header(jpeg_decompress_struct& jpeg, JpegState& state, std::span<const std::byte> bytes) {
  jpeg.err = jpeg_std_error(&state.errors);
  jpeg.err->error_exit = on_jpeg_error;
  jpeg.err->emit_message = on_jpeg_message;
  jpeg.client_data = &state;
  if (setjmp(state.leave) != 0) return false;
  jpeg_create_decompress(&jpeg);
  jpeg.client_data = &state;
  state.progress.progress_monitor = on_jpeg_progress;
  jpeg.progress = &state.progress;
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  return true;
}

bool read_rows(jpeg_decompress_struct& jpeg, JpegState& state, unsigned char* texels, std::size_t row_bytes) {
  if (setjmp(state.leave) != 0) return false;
  jpeg.dct_method = JDCT_ISLOW;  // the same numbers with and without SIMD
  jpeg.out_color_space = jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    JSAMPROW row = texels + jpeg.output_scanline * row_bytes;
    jpeg_read_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_decompress(&jpeg);
  return true;
}

/// Throws unless this is a kind of JPEG that is read and the file can hold its pixels: every component has at least one
/// bit for each of its blocks, and the finest has a block for 8x8 pixels.
void check_jpeg(const jpeg_decompress_struct& jpeg, std::size_t file_size, const std::string& path) {
  const auto refuse = [&](const std::string& reason) {
    throw Error(ErrorKind::file, fmt::format("{}: {}", path, reason));
  };
  const bool color =
      jpeg.num_components == 3 && (jpeg.jpeg_color_space == JCS_YCbCr || jpeg.jpeg_color_space == JCS_RGB);
  if (jpeg.jpeg_color_space == JCS_CMYK || jpeg.jpeg_color_space == JCS_YCCK)
    refuse("is a JPEG file with the four inks of CMYK; save it as RGB");
  if (!color && !(jpeg.num_components == 1 && jpeg.jpeg_color_space == JCS_GRAYSCALE))
    refuse(fmt::format("is a JPEG file with {} unknown channels; save it as RGB or grey", jpeg.num_components));
  if (jpeg.arith_code) refuse("is a JPEG file with arithmetic coding; save it with the usual Huffman coding");
  check_picture_size(jpeg.image_width, jpeg.image_height, path);
  const std::uint64_t pixels = std::uint64_t{jpeg.image_width} * jpeg.image_height;
  if (pixels / 512 > file_size) {
    refuse(fmt::format("announces {}x{} pixels but has only {} bytes: it is damaged or truncated", jpeg.image_width,
                       jpeg.image_height, file_size));
  }
}

}  // namespace

bool is_jpeg(std::span<const std::byte> bytes) {
  constexpr std::array<unsigned char, 3> kMagic = {0xff, 0xd8, 0xff};
  return bytes.size() >= kMagic.size() && std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
}

Bitmap decode_jpeg(std::span<const std::byte> bytes, const std::string& path) {
  JpegState state;
  JpegReader reader;
  const auto damaged = [&] {
    return Error(ErrorKind::file, fmt::format("{}: is a damaged JPEG file: {}", path, state.message.data()));
  };
  if (!read_header(reader.jpeg, state, bytes)) throw damaged();
  check_jpeg(reader.jpeg, bytes.size(), path);
  const std::uint32_t channels = reader.jpeg.num_components == 1 ? 1 : 3;
  Bitmap bitmap = make_bitmap(reader.jpeg.image_width, reader.jpeg.image_height, channels, BitmapFormat::u8);
  bitmap.color_space = ColorSpace::srgb;
  if (!read_rows(reader.jpeg, state, reinterpret_cast<unsigned char*>(bitmap.texels.data()), bitmap.row_bytes()))
    throw damaged();
  if (state.extra_bytes)
    bitmap.notes.push_back(fmt::format("{}: bytes between the parts of the file are skipped", path));
  return bitmap;
}

}  // namespace etendue
