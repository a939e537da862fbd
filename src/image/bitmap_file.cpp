#include "image/bitmap_file.h"

#include <array>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>

#include "image/exr_io.h"
#include "image/files.h"

namespace etendue {
namespace {

void write_exr_bitmap(const std::string& path, const Bitmap& bitmap) {
  Imf::Header header = make_exr_header(bitmap.width, bitmap.height, {}, path);
  header.compression() = Imf::ZIP_COMPRESSION;
  const Imf::PixelType type = bitmap.format == BitmapFormat::f16 ? Imf::HALF : Imf::FLOAT;
  const bool color = bitmap.channels > 2;
  const std::array<const char*, 4> names =
      color ? std::array<const char*, 4>{"R", "G", "B", "A"} : std::array<const char*, 4>{"Y", "A", "", ""};
  Imf::FrameBuffer buffer;
  for (std::uint32_t c = 0; c < bitmap.channels; ++c) {
    header.channels().insert(names[c], Imf::Channel(type));
    add_slice(buffer, names[c], type, bitmap.texels.data() + c * bytes_of(bitmap.format),
              bitmap.channels * bytes_of(bitmap.format), header.dataWindow());
  }
  write_file_atomically(path, encode_exr(header, buffer, path));
}

}  // namespace

const char* bitmap_extension(const Bitmap& bitmap) {
  return bitmap.format == BitmapFormat::u8 || bitmap.color_space == ColorSpace::srgb ? "png" : "exr";
}

void write_bitmap(const std::string& path, const Bitmap& bitmap) {
  bitmap_extension(bitmap) == std::string("png") ? write_png_bitmap(path, bitmap) : write_exr_bitmap(path, bitmap);
}

}  // namespace etendue
