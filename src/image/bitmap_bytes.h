#pragma once
/// Pictures inside other files.

#include <cstddef>
#include <span>
#include <string>

#include "image/bitmap.h"

namespace etendue {

/// Like read_bitmap, but from bytes in memory; `name` is for messages.
Bitmap decode_picture(std::span<const std::byte> bytes, const std::string& name);

}  // namespace etendue
