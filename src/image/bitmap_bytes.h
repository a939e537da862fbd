#pragma once
/// Pictures that lie in other files.

#include <cstddef>
#include <span>
#include <string>

#include "image/bitmap.h"

namespace etendue {

/// As read_bitmap, of bytes; `name` is for messages.
Bitmap decode_picture(std::span<const std::byte> bytes, const std::string& name);

}  // namespace etendue
