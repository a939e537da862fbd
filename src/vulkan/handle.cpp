#include "vulkan/handle.h"

#include <atomic>
#include <mutex>
#include <set>
#include <vector>

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

std::shared_ptr<const void> lend(VkDevice device, std::shared_ptr<const void> owner) {
  const void* const lent = owner.get();
  return {lent, [device, owner = std::move(owner)](const void*) {
            if (!is_abandoned(device)) return;
            static auto* const kept = new std::vector<std::shared_ptr<const void>>;  // survives even static objects
            const std::lock_guard lock(g_mutex);
            kept->push_back(owner);
          }};
}

}  // namespace etendue::vulkan
