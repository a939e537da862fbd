#pragma once
/// Vulkan results become errors in every build type.

#include <string_view>

#include <volk.h>

namespace etendue::vulkan {

/// Name of a result code, for example "VK_ERROR_DEVICE_LOST".
const char* result_name(VkResult result);

/// Throws Error unless `result` is VK_SUCCESS: `action` completes "Vulkan could not …". A lost device throws
/// DeviceLost, exhausted memory ends the program with exit code 5, a missing driver or feature with 4.
void check(VkResult result, std::string_view action);

}  // namespace etendue::vulkan
