#pragma once
/// Pictures of scenes as files, so that reading one gives the same numbers again.

#include <string>

#include "image/bitmap.h"

namespace etendue {

/// "png" for 8-bit codes and for floats that are coded by the curve of sRGB, which only 16-bit PNG files give; else
/// "exr".
const char* bitmap_extension(const Bitmap& bitmap);

/// Writes the picture in the format of that extension. Throws Error(file), also where the numbers of a PNG file would
/// not be those of the picture.
void write_bitmap(const std::string& path, const Bitmap& bitmap);

/// Internal: the PNG half of it.
void write_png_bitmap(const std::string& path, const Bitmap& bitmap);

}  // namespace etendue
