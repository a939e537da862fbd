#include "vulkan/handle.h"

#include <atomic>
#include <mutex>
#include <set>

namespace etendue::vulkan {
namespace {

std::atomic<bool> g_any{false};  // lets the common case go without the lock
std::mutex g_mutex;
std::set<VkDevice> g_devices;

}  // namespace

void abandon(VkDevice device) {
  const std::lock_guard lock(g_mutex);
  g_devices.insert(device);
  g_any = true;
}

bool is_abandoned(VkDevice device) {
  if (!g_any) return false;
  const std::lock_guard lock(g_mutex);
  return g_devices.contains(device);
}

bool any_abandoned() {
  return g_any;
}

}  // namespace etendue::vulkan
