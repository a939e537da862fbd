#pragma once
/// The readers of image.h on bytes in memory; `path` is for messages only. Internal to src/image, its tests and its
/// fuzzers.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "image/bitmap.h"
#include "image/image.h"
#include "image/picture_header.h"

namespace etendue {

/// Largest width or height and largest number of pixels of a file: the same as for a film. A file of a few kilobytes
/// may unpack to that many.
inline constexpr std::uint32_t kMaxImageSide = 65536;
inline constexpr std::uint64_t kMaxImagePixels = std::uint64_t{1} << 26;
/// Largest file: a film of that many pixels, barely compressed.
inline constexpr std::uint64_t kMaxImageBytes = std::uint64_t{1} << 34;

/// The bytes of a picture or film. Throws Error(file), also if there are more than kMaxImageBytes.
std::vector<std::byte> read_whole_image(const std::string& path);

bool is_exr(std::span<const std::byte> bytes);
bool is_png(std::span<const std::byte> bytes);
bool is_jpeg(std::span<const std::byte> bytes);
bool is_webp(std::span<const std::byte> bytes);
bool is_bmp(std::span<const std::byte> bytes);
bool is_hdr(std::span<const std::byte> bytes);

/// A bitmap of zeros.
Bitmap make_bitmap(std::uint64_t width, std::uint64_t height, std::uint32_t channels, BitmapFormat format);
/// Throws Error(file) unless the size is within the limits above.
void check_picture_size(std::uint64_t width, std::uint64_t height, const std::string& path);

/// Recognised by content; anything unrecognised is tried as HDR.
Bitmap decode_bitmap(std::span<const std::byte> bytes, const std::string& path, const BitmapOptions& options = {});
Bitmap decode_exr_bitmap(std::span<const std::byte> bytes, const std::string& path, const std::string& layer = {});
Bitmap decode_png_bitmap(std::span<const std::byte> bytes, const std::string& path);
Bitmap decode_jpeg(std::span<const std::byte> bytes, const std::string& path);
Bitmap decode_webp(std::span<const std::byte> bytes, const std::string& path);
Bitmap decode_bmp(std::span<const std::byte> bytes, const std::string& path);
Bitmap decode_hdr(std::span<const std::byte> bytes, const std::string& path);

/// `beside`: additional floating-point channels to be read if present.
Image decode_exr_image(std::span<const std::byte> bytes, const std::string& path,
                       std::span<const std::string> beside = {});
Image decode_png(std::span<const std::byte> bytes, const std::string& path);
/// Size and texts of a PNG file of `file_size` bytes from its first bytes, which must reach to its pixels.
PictureHeader decode_png_header(std::span<const std::byte> bytes, std::uint64_t file_size, const std::string& path);
/// Throws Error(file) if these are the bytes of a film file that does not match its checksum. EXR pictures have none
/// and pass.
void verify_film(std::span<const std::byte> bytes, const std::string& path);
/// `verify` is off only where a fuzzer must get past the checksum.
FilmFile decode_film(std::span<const std::byte> bytes, const std::string& path, bool verify);

}  // namespace etendue
