#pragma once
/// Recording, submitting and waiting: one command buffer that is reused.

#include <cstddef>
#include <span>

#include "vulkan/kernel.h"

namespace etendue::vulkan {

class Commands {
 public:
  explicit Commands(const Context& context);

  /// Runs `kernel` over `groups` workgroups and waits; returns the seconds from submission to completion. `sets` are
  /// its sets 0, 1, …. Throws DeviceLost, or DeviceHung if the device does not finish within `timeout_seconds`, in
  /// which case it is abandoned.
  double dispatch(const PipelineLayout& layout, const Kernel& kernel, std::initializer_list<const BindingSet*> sets,
                  std::span<const std::byte> push_constants, std::uint32_t groups, double timeout_seconds);

  /// Copies host bytes into a buffer at `offset`, in chunks through a staging buffer.
  void upload(const Buffer& target, VkDeviceSize offset, std::span<const std::byte> bytes);
  /// Copies buffer bytes from `offset` to the host.
  void download(const Buffer& source, VkDeviceSize offset, std::span<std::byte> bytes);
  /// Builds one acceleration structure of one geometry.
  void build(const VkAccelerationStructureBuildGeometryInfoKHR& structure,
             const VkAccelerationStructureBuildRangeInfoKHR& range);
  /// Sets every 32-bit word of the buffer.
  void fill(const Buffer& target, std::uint32_t word);

 private:
  void begin();
  void submit_and_wait(const char* action, double timeout_seconds);
  const Buffer& staging();

  const Context* context_;
  Handle<VkCommandPool, &vkDestroyCommandPool> pool_;
  VkCommandBuffer buffer_ = VK_NULL_HANDLE;
  Handle<VkFence, &vkDestroyFence> fence_;
  Buffer staging_;
};

}  // namespace etendue::vulkan
