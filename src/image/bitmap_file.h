#pragma once
/// Writes the pictures of scenes as files from which the same numbers can be read again.

#include <string>

#include "image/bitmap.h"

namespace etendue {

/// "png" for 8-bit codes and for sRGB-encoded floats, which come only from 16-bit PNG files; otherwise "exr".
const char* bitmap_extension(const Bitmap& bitmap);

/// Writes the picture in the format of that extension. Throws Error(file), also if a PNG file could not hold exactly
/// the same numbers.
void write_bitmap(const std::string& path, const Bitmap& bitmap);

/// Internal: the PNG half of it.
void write_png_bitmap(const std::string& path, const Bitmap& bitmap);

}  // namespace etendue
