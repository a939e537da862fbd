#pragma once
/// Acceleration structures, which a driver builds from boxes and their instances, so that kernels can query which of
/// them a ray meets.

#include <cstdint>
#include <span>
#include <vector>

#include "vulkan/commands.h"

namespace etendue::vulkan {

/// Bytes of a structure over so many boxes or instances, and the additional bytes needed to build it.
struct StructureSize {
  std::uint64_t kept = 0, scratch = 0;
};

enum class StructureKind { boxes, instances };

/// Throws Error(lost) if there are more than the device supports.
StructureSize structure_size(const Context& context, StructureKind kind, std::uint32_t count);

/// A structure in memory of its own.
class AccelerationStructure {
 public:
  AccelerationStructure() = default;
  /// `input` is an array of VkAabbPositionsKHR or VkAccelerationStructureInstanceKHR. The context's device must have
  /// been opened for ray queries (Requirements::ray_queries).
  AccelerationStructure(const Context& context, Commands& commands, StructureKind kind,
                        std::span<const std::byte> input, std::uint32_t count);

  VkAccelerationStructureKHR get() const { return structure_.get(); }
  /// The address by which instances refer to it.
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
