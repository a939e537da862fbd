#include "vulkan/commands.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <vector>

#include <fmt/core.h>

#include "core/errors.h"
#include "vulkan/check.h"

namespace etendue::vulkan {
namespace {

constexpr VkDeviceSize kStagingBytes = VkDeviceSize{16} << 20;
constexpr double kTransferTimeout = 60.0;  // seconds; a copy of kStagingBytes takes milliseconds
constexpr double kBuildTimeout = 300.0;    // seconds; on a CPU, millions of boxes take several

// Everything before is visible to everything after; passes are long, so finer barriers would buy nothing.
void full_barrier(VkCommandBuffer buffer) {
  const VkMemoryBarrier barrier{
      .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
      .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_HOST_WRITE_BIT,
      .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_UNIFORM_READ_BIT |
                       VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_HOST_READ_BIT};
  constexpr VkPipelineStageFlags kStages =
      VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | VK_PIPELINE_STAGE_HOST_BIT;
  vkCmdPipelineBarrier(buffer, kStages, kStages, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

}  // namespace

Commands::Commands(const Context& context) : context_(&context) {
  const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = context.queue_family()};
  VkCommandPool pool = VK_NULL_HANDLE;
  check(vkCreateCommandPool(context.device(), &pool_info, nullptr, &pool), "create a command pool");
  pool_ = {context.device(), pool};
  const VkCommandBufferAllocateInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                         .commandPool = pool,
                                         .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                         .commandBufferCount = 1};
  check(vkAllocateCommandBuffers(context.device(), &info, &buffer_), "allocate a command buffer");
  const VkFenceCreateInfo fence_info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  VkFence fence = VK_NULL_HANDLE;
  check(vkCreateFence(context.device(), &fence_info, nullptr, &fence), "create a fence");
  fence_ = {context.device(), fence};
}

void Commands::begin() {
  const VkCommandBufferBeginInfo info{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  check(vkBeginCommandBuffer(buffer_, &info), "begin recording commands");
  full_barrier(buffer_);
}

void Commands::submit_and_wait(const char* action, double timeout_seconds) {
  full_barrier(buffer_);
  check(vkEndCommandBuffer(buffer_), "finish recording commands");
  const VkSubmitInfo submit{
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &buffer_};
  const VkFence fence = fence_.get();
  check(vkQueueSubmit(context_->queue(), 1, &submit, fence), action);
  timeout_seconds = std::min(timeout_seconds, context_->options().max_wait_seconds);
  const VkResult waited =
      vkWaitForFences(context_->device(), 1, &fence, VK_TRUE, static_cast<std::uint64_t>(timeout_seconds * 1e9));
  if (waited == VK_TIMEOUT) {
    abandon(context_->device());
    throw DeviceHung(fmt::format(
        "Vulkan could not {}: '{}' did not finish within {:g} s; it hangs or is far too busy, choose another "
        "--device.",
        action, context_->info().name, timeout_seconds));
  }
  check(waited, action);
  check(vkResetFences(context_->device(), 1, &fence), "reset a fence");
}

double Commands::dispatch(const PipelineLayout& layout, const Kernel& kernel,
                          std::initializer_list<const BindingSet*> sets, std::span<const std::byte> push_constants,
                          std::uint32_t groups, double timeout_seconds) {
  begin();
  vkCmdBindPipeline(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, kernel.get());
  std::vector<VkDescriptorSet> handles;
  for (const BindingSet* set : sets) handles.push_back(set->get());
  vkCmdBindDescriptorSets(buffer_, VK_PIPELINE_BIND_POINT_COMPUTE, layout.get(), 0,
                          static_cast<std::uint32_t>(handles.size()), handles.data(), 0, nullptr);
  if (!push_constants.empty()) {
    vkCmdPushConstants(buffer_, layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                       static_cast<std::uint32_t>(push_constants.size()), push_constants.data());
  }
  vkCmdDispatch(buffer_, groups, 1, 1);
  const auto start = std::chrono::steady_clock::now();
  submit_and_wait("run a compute pass", timeout_seconds);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

const Buffer& Commands::staging() {
  if (staging_.size() == 0) staging_ = Buffer(*context_, kStagingBytes, 0, Buffer::Memory::host, "staging");
  return staging_;
}

void Commands::upload(const Buffer& target, VkDeviceSize offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto chunk = bytes.first(std::min<std::size_t>(bytes.size(), kStagingBytes));
    std::memcpy(staging().mapped().data(), chunk.data(), chunk.size());
    begin();
    const VkBufferCopy copy{.srcOffset = 0, .dstOffset = offset, .size = chunk.size()};
    vkCmdCopyBuffer(buffer_, staging_.get(), target.get(), 1, &copy);
    submit_and_wait("copy data to the device", kTransferTimeout);
    offset += chunk.size();
    bytes = bytes.subspan(chunk.size());
  }
}

void Commands::download(const Buffer& source, VkDeviceSize offset, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const auto chunk = bytes.first(std::min<std::size_t>(bytes.size(), kStagingBytes));
    const Buffer& from = staging();
    begin();
    const VkBufferCopy copy{.srcOffset = offset, .dstOffset = 0, .size = chunk.size()};
    vkCmdCopyBuffer(buffer_, source.get(), from.get(), 1, &copy);
    submit_and_wait("copy data from the device", kTransferTimeout);
    std::memcpy(chunk.data(), from.mapped().data(), chunk.size());
    offset += chunk.size();
    bytes = bytes.subspan(chunk.size());
  }
}

void Commands::build(const VkAccelerationStructureBuildGeometryInfoKHR& structure,
                     const VkAccelerationStructureBuildRangeInfoKHR& range) {
  constexpr VkPipelineStageFlags kBuild = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
  constexpr VkAccessFlags kStructures =
      VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR | VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
  // Makes earlier uploads and builds visible to later builds and queries.
  const VkMemoryBarrier before{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT | kStructures,
                               .dstAccessMask = VK_ACCESS_SHADER_READ_BIT | kStructures};
  const VkMemoryBarrier after{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                              .srcAccessMask = kStructures,
                              .dstAccessMask = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR};
  const VkAccelerationStructureBuildRangeInfoKHR* const ranges = &range;
  begin();
  vkCmdPipelineBarrier(buffer_, VK_PIPELINE_STAGE_TRANSFER_BIT | kBuild, kBuild, 0, 1, &before, 0, nullptr, 0, nullptr);
  vkCmdBuildAccelerationStructuresKHR(buffer_, 1, &structure, &ranges);
  vkCmdPipelineBarrier(buffer_, kBuild, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kBuild, 0, 1, &after, 0, nullptr, 0,
                       nullptr);
  submit_and_wait("build an acceleration structure", kBuildTimeout);
}

void Commands::fill(const Buffer& target, std::uint32_t word) {
  begin();
  vkCmdFillBuffer(buffer_, target.get(), 0, VK_WHOLE_SIZE, word);
  submit_and_wait("clear a buffer", kTransferTimeout);
}

}  // namespace etendue::vulkan
