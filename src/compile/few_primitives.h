#pragma once
/// Chooses the primitives that are tested before a ray enters the tree.

#include <cstdint>
#include <vector>

#include "compile/box.h"

namespace etendue {

/// Indices, in ascending order, of at most kFewPrimitives large primitives, such as the walls of a room or the ground
/// below a statue; fewer rays meet the tree of the others. If there are no more primitives than that, all are returned.
/// Only the first `eligible` boxes belong to primitives that may be outside the tree.
std::vector<std::uint32_t> choose_few_primitives(const std::vector<Box>& boxes, std::size_t eligible = ~std::size_t{0});

}  // namespace etendue
