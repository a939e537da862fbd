#pragma once
/// Pictures for textures, which are computed so that the repository need not contain them.

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace etendue::sculpt {

/// The names of the pictures: wood (boards; repeats), porcelain (blue on white; repeats in u), orange (peel for a
/// sphere), cloth (woven threads; repeats).
const std::vector<std::string>& picture_kinds();
/// A square picture with sides of `size` pixels, in linear light.
Image make_picture(const std::string& kind, std::uint32_t size);

}  // namespace etendue::sculpt
