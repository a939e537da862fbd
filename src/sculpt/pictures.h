#pragma once
/// Pictures for textures, computed so that the repository need not carry them.

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace etendue::sculpt {

/// Their names: wood (boards, repeats), porcelain (blue on white, repeats in u), orange (peel for a sphere), cloth (a
/// woven check, repeats).
const std::vector<std::string>& picture_kinds();
/// Square, `size` pixels a side; linear light.
Image make_picture(const std::string& kind, std::uint32_t size);

}  // namespace etendue::sculpt
