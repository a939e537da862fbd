/// Memory of the program that a device reads.

#include <cstdint>
#include <memory>

#include <gtest/gtest.h>

#include "vulkan/handle.h"

namespace etendue::vulkan {
namespace {

// Devices that nobody has opened: their names are enough.
VkDevice device(std::uintptr_t name) {
  return reinterpret_cast<VkDevice>(name);
}

TEST(GpuLentMemory, GoesWithItsLastReader) {
  auto owner = std::make_shared<const int>(7);
  const std::weak_ptr<const int> watched = owner;
  std::shared_ptr<const void> lent = lend(device(16), std::move(owner));
  std::shared_ptr<const void> again = lent;
  EXPECT_EQ(lent.get(), watched.lock().get());
  lent.reset();
  EXPECT_FALSE(watched.expired());
  again.reset();
  EXPECT_TRUE(watched.expired());
}

// A kernel that hangs may go on reading in a thread of the driver.
TEST(GpuLentMemory, StaysForAnAbandonedDevice) {
  auto owner = std::make_shared<const int>(7);
  const std::weak_ptr<const int> watched = owner;
  std::shared_ptr<const void> lent = lend(device(32), std::move(owner));
  abandon(device(32));
  lent.reset();
  EXPECT_FALSE(watched.expired());
}

}  // namespace
}  // namespace etendue::vulkan
