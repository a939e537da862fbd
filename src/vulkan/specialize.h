#pragma once
/// SPIR-V with its specialization constants fixed.

#include <cstdint>
#include <span>
#include <vector>

namespace etendue::vulkan {

/// Value of `layout(constant_id = id)`.
struct Specialization {
  std::uint32_t id = 0;
  std::uint32_t value = 0;
  bool operator==(const Specialization&) const = default;
};

/// The module `spirv` with these values in place of its specialization constants, without the code that they rule out.
/// Values of constants that it does not have are ignored. A driver reads and lowers a whole module before it folds its
/// constants, and before it looks into its cache; for a kernel with every feature, that is most of the time to the
/// first sample, and more than some drivers can handle. Throws Error(bug) with the optimizer's message if `spirv` is
/// not a valid module.
std::vector<std::uint32_t> specialize(std::span<const std::uint32_t> spirv, std::span<const Specialization> constants);

}  // namespace etendue::vulkan
