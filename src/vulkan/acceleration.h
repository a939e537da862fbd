#pragma once
/// Acceleration structures: what a driver makes of boxes and their instances, so that kernels can ask it which of them
/// a ray meets.

#include <cstdint>
#include <span>
#include <vector>

#include "vulkan/commands.h"

namespace etendue::vulkan {

/// Bytes that a structure over so many boxes, or instances, takes: once it is built, and beside that while it is.
struct StructureSize {
  std::uint64_t kept = 0, scratch = 0;
};

enum class StructureKind { boxes, instances };

/// Throws Error(lost) where they are more than the device takes.
StructureSize structure_size(const Context& context, StructureKind kind, std::uint32_t count);

/// A structure in memory of its own.
class AccelerationStructure {
 public:
  AccelerationStructure() = default;
  /// `input`: VkAabbPositionsKHR or VkAccelerationStructureInstanceKHR, one behind the other. The context's device was
  /// opened for ray queries (Requirements::ray_queries).
  AccelerationStructure(const Context& context, Commands& commands, StructureKind kind,
                        std::span<const std::byte> input, std::uint32_t count);

  VkAccelerationStructureKHR get() const { return structure_.get(); }
  /// By which instances refer to it.
  std::uint64_t address() const;

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  Buffer memory_;
  Handle<VkAccelerationStructureKHR, &vkDestroyAccelerationStructureKHR> structure_;
};

/// An instance of a structure of boxes; rows of world_from_mesh.
VkAccelerationStructureInstanceKHR structure_instance(const AccelerationStructure& boxes,
                                                      const float (&world_from_mesh)[3][4], std::uint32_t name);

}  // namespace etendue::vulkan
