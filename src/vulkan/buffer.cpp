#include "vulkan/buffer.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

#include <fmt/core.h>

#include "core/page_memory.h"
#include "vulkan/check.h"

namespace etendue::vulkan {

namespace {

std::atomic<std::uint64_t> g_bytes{0}, g_peak{0};

// A CPU driver's memory is that of its process.
void advise_pages_of_driver(const Context& context, VkDeviceMemory memory, VkDeviceSize bytes) {
  void* start = nullptr;
  if (!context.is_cpu() || bytes < kLeastHugeBytes) return;
  if (vkMapMemory(context.device(), memory, 0, VK_WHOLE_SIZE, 0, &start) != VK_SUCCESS) return;
  advise_huge_pages(start, bytes);
  vkUnmapMemory(context.device(), memory);
}

}  // namespace

MemoryUse memory_use() {
  return {g_bytes, g_peak};
}

void reset_memory_peak() {
  g_peak = g_bytes.load();
}

CountedBytes::CountedBytes(std::uint64_t bytes) : bytes_(bytes) {
  const std::uint64_t now = g_bytes += bytes;
  std::uint64_t peak = g_peak;
  while (peak < now && !g_peak.compare_exchange_weak(peak, now)) {
  }
}

CountedBytes::~CountedBytes() {
  g_bytes -= bytes_;
}

Buffer::Buffer(const Context& context, VkDeviceSize size, VkBufferUsageFlags usage, Memory memory, const char* what)
    : size_(std::max<VkDeviceSize>(size, 16)) {
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .size = size_,
                                .usage = usage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
  VkBuffer buffer = VK_NULL_HANDLE;
  check(vkCreateBuffer(context.device(), &info, nullptr, &buffer),
        fmt::format("create the {} buffer of {} bytes", what, size_));
  buffer_ = {context.device(), buffer};

  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(context.device(), buffer, &needs);
  constexpr VkMemoryPropertyFlags kMapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const bool host = memory == Memory::host;
  const VkMemoryAllocateFlagsInfo addressed{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                            .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
  const VkMemoryAllocateInfo allocation{
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
      .pNext = (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0 ? &addressed : nullptr,
      .allocationSize = needs.size,
      .memoryTypeIndex =
          context.memory_type(needs.memoryTypeBits, host ? kMapped : 0,
                              host ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)};
  VkDeviceMemory device_memory = VK_NULL_HANDLE;
  check(vkAllocateMemory(context.device(), &allocation, nullptr, &device_memory),
        fmt::format("allocate {} bytes for the {}", needs.size, what));
  memory_ = {context.device(), device_memory};
  counted_ = CountedBytes(needs.size);
  check(vkBindBufferMemory(context.device(), buffer, device_memory, 0), fmt::format("bind the memory of the {}", what));
  if (!host) advise_pages_of_driver(context, device_memory, needs.size);
  if (host)
    check(vkMapMemory(context.device(), device_memory, 0, VK_WHOLE_SIZE, 0, &mapped_), fmt::format("map the {}", what));
}

std::optional<Buffer> Buffer::in_place(const Context& context, const std::shared_ptr<const void>& owner,
                                       std::span<const std::byte> bytes, VkBufferUsageFlags usage, const char* what) {
  constexpr auto kHandle = VK_EXTERNAL_MEMORY_HANDLE_TYPE_HOST_ALLOCATION_BIT_EXT;
  const std::uint64_t step = context.host_memory_alignment();
  const VkDeviceSize whole = (bytes.size() + kPageBytes - 1) / kPageBytes * kPageBytes;
  if (step == 0 || kPageBytes % step != 0 || bytes.empty() ||
      reinterpret_cast<std::uintptr_t>(bytes.data()) % step != 0)
    return {};
  void* const start = const_cast<std::byte*>(bytes.data());

  const VkExternalMemoryBufferCreateInfo external{.sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO,
                                                  .handleTypes = kHandle};
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                .pNext = &external,
                                .size = bytes.size(),
                                .usage = usage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT};
  Buffer made;
  made.lent_ = lend(context.device(), owner);
  VkBuffer buffer = VK_NULL_HANDLE;
  check(vkCreateBuffer(context.device(), &info, nullptr, &buffer),
        fmt::format("create the {} buffer of {} bytes", what, bytes.size()));
  made.buffer_ = {context.device(), buffer};
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(context.device(), buffer, &needs);
  VkMemoryHostPointerPropertiesEXT types{.sType = VK_STRUCTURE_TYPE_MEMORY_HOST_POINTER_PROPERTIES_EXT};
  if (vkGetMemoryHostPointerPropertiesEXT(context.device(), kHandle, start, &types) != VK_SUCCESS) return {};
  types.memoryTypeBits &= needs.memoryTypeBits;
  if (types.memoryTypeBits == 0 || needs.size > whole) return {};

  const VkImportMemoryHostPointerInfoEXT import{
      .sType = VK_STRUCTURE_TYPE_IMPORT_MEMORY_HOST_POINTER_INFO_EXT, .handleType = kHandle, .pHostPointer = start};
  const VkMemoryAllocateInfo allocation{
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
      .pNext = &import,
      .allocationSize = whole,
      .memoryTypeIndex = context.memory_type(types.memoryTypeBits, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)};
  VkDeviceMemory memory = VK_NULL_HANDLE;
  if (vkAllocateMemory(context.device(), &allocation, nullptr, &memory) != VK_SUCCESS) return {};
  made.memory_ = {context.device(), memory};
  made.counted_ = CountedBytes(whole);
  made.size_ = bytes.size();
  check(vkBindBufferMemory(context.device(), buffer, memory, 0), fmt::format("bind the memory of the {}", what));
  return made;
}

TexelView make_texel_view(const Context& context, const Buffer& buffer, VkFormat format) {
  const VkBufferViewCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                    .buffer = buffer.get(),
                                    .format = format,
                                    .range = VK_WHOLE_SIZE};
  VkBufferView view = VK_NULL_HANDLE;
  check(vkCreateBufferView(context.device(), &info, nullptr, &view), "create a texel view");
  return {context.device(), view};
}

}  // namespace etendue::vulkan
