#pragma once
/// Which primitives are tested before a ray enters the tree.

#include <cstdint>
#include <vector>

#include "compile/box.h"

namespace etendue {

/// Indices of at most kFewPrimitives large primitives without which the tree of the others is met by fewer rays: the
/// walls of a room, the ground below a statue. All of them when they are no more than that. Ascending. Only the first
/// `eligible` boxes are those of primitives that may stand outside.
std::vector<std::uint32_t> choose_few_primitives(const std::vector<Box>& boxes, std::size_t eligible = ~std::size_t{0});

}  // namespace etendue
