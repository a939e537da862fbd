#pragma once
/// Specialized modules, kept from one start of the program to the next.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "vulkan/specialize.h"

namespace etendue::vulkan {

/// Does what specialize() does, and keeps the results in files. The geometry of the few primitives outside a tree is
/// among the constants, so that most scenes have modules of their own: the kMost used last are kept.
class ModuleCache {
 public:
  static constexpr std::size_t kMost = 64;

  /// Without a folder nothing is kept.
  explicit ModuleCache(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Throws like specialize().
  std::vector<std::uint32_t> specialized(std::span<const std::uint32_t> spirv,
                                         std::span<const Specialization> constants) const;
  /// The same if it is kept, otherwise nothing.
  std::optional<std::vector<std::uint32_t>> find(std::span<const std::uint32_t> spirv,
                                                 std::span<const Specialization> constants) const;

 private:
  void remove_old() const;

  std::filesystem::path folder_;
};

}  // namespace etendue::vulkan
