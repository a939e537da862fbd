#include "gpu/device_limits.h"

#include <fmt/core.h>

#include "core/errors.h"

namespace etendue {
namespace {

constexpr const char* kRemedy = "use coarser meshes or a smaller image, another --device, or --device reference";

[[noreturn]] void refuse(const std::string& thing, const std::string& unit, std::uint64_t needed,
                         const DeviceLimits& limits, std::uint64_t available, const std::string& limit) {
  throw Error(ErrorKind::lost, fmt::format("The {} needs {} {}, but '{}' has {} ({}); {}.", thing, needed, unit,
                                           limits.device, available, limit, kRemedy));
}

void check_need(const DeviceNeed& need, const DeviceLimits& limits) {
  if (need.kind == DeviceNeed::Kind::memory) return;
  if (need.kind == DeviceNeed::Kind::storage && need.bytes > limits.max_storage_buffer_range)
    refuse(need.what, "bytes in one binding", need.bytes, limits, limits.max_storage_buffer_range,
           "maxStorageBufferRange");
  if (need.bytes > limits.max_memory_allocation_size)
    refuse(need.what, "bytes in one piece", need.bytes, limits, limits.max_memory_allocation_size,
           "maxMemoryAllocationSize");
}

}  // namespace

DeviceLimits limits_of(const vulkan::Context& context) {
  return {.device = context.info().name,
          .max_storage_buffer_range = context.limits().maxStorageBufferRange,
          .max_memory_allocation_size = context.max_allocation(),
          .memory = context.available_memory().bytes,
          .memory_name = context.available_memory().name};
}

void check_needs(std::span<const DeviceNeed> needs, const DeviceLimits& limits) {
  std::uint64_t sum = 0;
  const DeviceNeed* largest = nullptr;
  for (const DeviceNeed& need : needs) {
    check_need(need, limits);
    sum += need.bytes;
    if (largest == nullptr || need.bytes > largest->bytes) largest = &need;
  }
  if (sum <= limits.memory || largest == nullptr) return;
  refuse(fmt::format("render, most of it the {} of {} bytes,", largest->what, largest->bytes), "bytes of device memory",
         sum, limits, limits.memory, limits.memory_name);
}

}  // namespace etendue
