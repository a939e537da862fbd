#pragma once
/// Holding a render against what a device can take, before anything is uploaded.

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
    memory,   ///< cut into pieces that fit; only the sum counts
  };
  const char* what;  ///< for messages: "tree", "film"
  std::uint64_t bytes = 0;
  Kind kind = Kind::table;
};

/// The limits that count, by their names in Vulkan.
struct DeviceLimits {
  std::string device;
  std::uint64_t max_storage_buffer_range = 0;
  std::uint64_t max_memory_allocation_size = 0;
  std::uint64_t memory = 0;  ///< bytes that are there for this process
  std::string memory_name;   ///< what says so
};
DeviceLimits limits_of(const vulkan::Context& context);

/// Throws Error(lost) that names the thing, the limit, what is needed and available, and what to do.
void check_needs(std::span<const DeviceNeed> needs, const DeviceLimits& limits);

}  // namespace etendue
