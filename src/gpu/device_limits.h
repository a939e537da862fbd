#pragma once
/// Checks a render against the device limits before anything is uploaded.

#include <cstdint>
#include <span>
#include <string>

#include "vulkan/context.h"

namespace etendue {

/// Something a render keeps in device memory.
struct DeviceNeed {
  enum class Kind {
    table,    ///< one allocation; choose_table_loads has found a way to read it
    storage,  ///< one allocation, bound whole as a storage buffer
    memory,   ///< split into pieces that fit; only the sum counts
  };
  const char* what;  ///< for messages: "tree", "film"
  std::uint64_t bytes = 0;
  Kind kind = Kind::table;
};

/// The relevant limits, by their names in Vulkan.
struct DeviceLimits {
  std::string device;
  std::uint64_t max_storage_buffer_range = 0;
  std::uint64_t max_memory_allocation_size = 0;
  std::uint64_t memory = 0;  ///< bytes available to this process
  std::string memory_name;   ///< where that number comes from
};
DeviceLimits limits_of(const vulkan::Context& context);

/// Throws Error(lost) that names the thing, the limit, what is needed and available, and what to do.
void check_needs(std::span<const DeviceNeed> needs, const DeviceLimits& limits);

}  // namespace etendue
