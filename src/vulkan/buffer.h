#pragma once
/// Device memory, and access to it.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "vulkan/context.h"

namespace etendue::vulkan {

/// Bytes of device memory that the buffers of this process hold, and the most they held since the last reset.
struct MemoryUse {
  std::uint64_t now = 0, peak = 0;
};
MemoryUse memory_use();
void reset_memory_peak();

/// Counts an allocation in memory_use during its lifetime.
class CountedBytes {
 public:
  CountedBytes() = default;
  explicit CountedBytes(std::uint64_t bytes);
  CountedBytes(CountedBytes&& other) noexcept : bytes_(std::exchange(other.bytes_, 0)) {}
  CountedBytes& operator=(CountedBytes&& other) noexcept {
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~CountedBytes();

 private:
  std::uint64_t bytes_ = 0;
};

/// A buffer with memory of its own.
class Buffer {
 public:
  enum class Memory { device, host };  ///< host: mapped and coherent for its whole life
  Buffer() = default;
  /// `what` names the contents in errors ("film", "BVH nodes"); size 0 is rounded up, so that every binding has a
  /// buffer.
  Buffer(const Context& context, VkDeviceSize size, VkBufferUsageFlags usage, Memory memory, const char* what);

  /// A buffer of the program's own memory, which kernels only read: `bytes` of `owner`, to which the whole last page
  /// belongs. Nothing where the device does not read them there.
  static std::optional<Buffer> in_place(const Context& context, const std::shared_ptr<const void>& owner,
                                        std::span<const std::byte> bytes, VkBufferUsageFlags usage, const char* what);

  VkBuffer get() const { return buffer_.get(); }
  VkDeviceSize size() const { return size_; }
  std::span<std::byte> mapped() const { return {static_cast<std::byte*>(mapped_), static_cast<std::size_t>(size_)}; }

 private:
  VkDeviceSize size_ = 0;
  CountedBytes counted_;
  std::shared_ptr<const void> lent_;  // memory that is not the device's own
  Handle<VkDeviceMemory, &vkFreeMemory> memory_;
  Handle<VkBuffer, &vkDestroyBuffer> buffer_;
  void* mapped_ = nullptr;
};

/// Formatted view of a buffer for texelFetch.
using TexelView = Handle<VkBufferView, &vkDestroyBufferView>;
TexelView make_texel_view(const Context& context, const Buffer& buffer, VkFormat format);

}  // namespace etendue::vulkan
