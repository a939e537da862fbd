#include "gpu/kernel_bindings.h"

#include <algorithm>

#include "gpu_types.h"

namespace etendue {
namespace {

constexpr VkDescriptorType kUniform = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
constexpr VkDescriptorType kTexels = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
constexpr VkDescriptorType kStorage = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;

std::uint32_t count(const std::vector<vulkan::Binding>& bindings, VkDescriptorType type) {
  return static_cast<std::uint32_t>(std::ranges::count(bindings, type, &vulkan::Binding::type));
}

}  // namespace

std::vector<vulkan::Binding> scene_bindings(TableLoads loads, bool queries) {
  const VkDescriptorType type = loads == TableLoads::texel_buffer ? kTexels : kStorage;
  std::vector<vulkan::Binding> bindings = {
      {gpu::kBindingRecords, type}, {gpu::kBindingGeometry, type}, {gpu::kBindingTables, type}};
  if (queries) bindings.push_back({gpu::kBindingStructure, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR});
  return bindings;
}

std::vector<vulkan::Binding> film_bindings() {
  return {{gpu::kBindingFrame, kUniform},   {gpu::kBindingFilter, kTexels},   {gpu::kBindingFilm, kStorage},
          {gpu::kBindingSetSums, kStorage}, {gpu::kBindingSamples, kStorage}, {gpu::kBindingReport, kStorage}};
}

std::vector<vulkan::Binding> request_bindings() {
  return {{gpu::kBindingFrame, kUniform},
          {gpu::kBindingFilter, kTexels},
          {gpu::kBindingRequests, kStorage},
          {gpu::kBindingResults, kStorage}};
}

std::uint32_t push_constant_bytes() {
  static_assert(sizeof(gpu::BsdfProbePass) <= sizeof(gpu::Pass));
  return sizeof(gpu::Pass);
}

vulkan::Requirements kernel_requirements(TableLoads loads) {
  vulkan::Requirements needed{.sets = 2,
                              .push_constant_bytes = push_constant_bytes(),
                              .uniform_bytes = sizeof(gpu::Frame),
                              .workgroup_lanes = gpu::kWorkgroupSize};
  const auto scene = scene_bindings(loads);
  for (const auto& kernel : {film_bindings(), request_bindings()}) {
    const auto most = [&](std::uint32_t& value, VkDescriptorType type) {
      value = std::max(value, count(scene, type) + count(kernel, type));
    };
    most(needed.storage_buffers, kStorage);
    most(needed.sampled_images, kTexels);  // Vulkan counts texel buffers as sampled images
    most(needed.uniform_buffers, kUniform);
  }
  return needed;
}

}  // namespace etendue
