#pragma once
/// Owning wrapper of a device-level Vulkan handle.

#include <memory>
#include <utility>

#include <volk.h>

namespace etendue::vulkan {

/// Gives up a device whose queue is still busy: none of its objects are destroyed any more, because destroying what a
/// queue uses crashes or waits for ever. The process should end soon, and by std::_Exit, because a driver's own threads
/// may never stop.
void abandon(VkDevice device);
bool is_abandoned(VkDevice device);
/// True when the process has abandoned any device.
bool any_abandoned();

/// What keeps memory of the program alive while `device` may read it: `owner` goes with the last copy of this, and
/// never once the device is abandoned, whose driver may go on reading.
std::shared_ptr<const void> lend(VkDevice device, std::shared_ptr<const void> owner);

/// Calls `*Destroy(device, handle, nullptr)` at the end of its lifetime, unless the device was abandoned. `Destroy`
/// points at volk's function pointer, which is only filled at run time.
template <typename T, auto Destroy>
class Handle {
 public:
  Handle() = default;
  Handle(VkDevice device, T handle) : device_(device), handle_(handle) {}
  Handle(Handle&& other) noexcept
      : device_(other.device_), handle_(std::exchange(other.handle_, static_cast<T>(VK_NULL_HANDLE))) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (handle_ != VK_NULL_HANDLE && !is_abandoned(device_)) (*Destroy)(device_, handle_, nullptr);
  }

  T get() const { return handle_; }
  explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  T handle_ = VK_NULL_HANDLE;
};

}  // namespace etendue::vulkan
