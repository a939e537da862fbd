#include "vulkan/kernel.h"

#include <algorithm>
#include <map>

#include <fmt/core.h>

#include "vulkan/acceleration.h"
#include "vulkan/check.h"

namespace etendue::vulkan {

SetLayout::SetLayout(const Context& context, std::vector<Binding> bindings) : bindings_(std::move(bindings)) {
  std::vector<VkDescriptorSetLayoutBinding> entries;
  for (const Binding& b : bindings_) {
    entries.push_back({.binding = b.number,
                       .descriptorType = b.type,
                       .descriptorCount = 1,
                       .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT});
  }
  const VkDescriptorSetLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                             .bindingCount = static_cast<std::uint32_t>(entries.size()),
                                             .pBindings = entries.data()};
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  check(vkCreateDescriptorSetLayout(context.device(), &info, nullptr, &layout), "create a descriptor layout");
  layout_ = {context.device(), layout};
}

PipelineLayout::PipelineLayout(const Context& context, std::initializer_list<const SetLayout*> sets,
                               std::uint32_t push_constant_bytes) {
  std::vector<VkDescriptorSetLayout> layouts;
  for (const SetLayout* set : sets) layouts.push_back(set->get());
  const VkPushConstantRange range{.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .offset = 0, .size = push_constant_bytes};
  const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                        .setLayoutCount = static_cast<std::uint32_t>(layouts.size()),
                                        .pSetLayouts = layouts.data(),
                                        .pushConstantRangeCount = push_constant_bytes > 0 ? 1u : 0u,
                                        .pPushConstantRanges = &range};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(context.device(), &info, nullptr, &layout), "create the pipeline layout");
  layout_ = {context.device(), layout};
}

BindingSet::BindingSet(const Context& context, const SetLayout& layout) : device_(context.device()), layout_(&layout) {
  std::map<VkDescriptorType, std::uint32_t> counts;
  for (const Binding& b : layout.bindings()) ++counts[b.type];
  std::vector<VkDescriptorPoolSize> sizes;
  sizes.reserve(counts.size());
  for (const auto& [type, count] : counts) sizes.push_back({type, count});
  const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = static_cast<std::uint32_t>(sizes.size()),
                                             .pPoolSizes = sizes.data()};
  VkDescriptorPool pool = VK_NULL_HANDLE;
  check(vkCreateDescriptorPool(device_, &pool_info, nullptr, &pool), "create a descriptor pool");
  pool_ = {device_, pool};
  const VkDescriptorSetLayout set_layout = layout.get();
  const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                         .descriptorPool = pool,
                                         .descriptorSetCount = 1,
                                         .pSetLayouts = &set_layout};
  check(vkAllocateDescriptorSets(device_, &info, &set_), "allocate a descriptor set");
}

void BindingSet::write(std::uint32_t binding, const VkDescriptorBufferInfo* buffer, const VkBufferView* view) {
  const auto& bindings = layout_->bindings();
  const auto entry = std::ranges::find(bindings, binding, &Binding::number);
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set_,
                                   .dstBinding = binding,
                                   .descriptorCount = 1,
                                   .descriptorType = entry->type,
                                   .pBufferInfo = buffer,
                                   .pTexelBufferView = view};
  vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

void BindingSet::bind(std::uint32_t binding, const Buffer& buffer) {
  const VkDescriptorBufferInfo info{.buffer = buffer.get(), .offset = 0, .range = VK_WHOLE_SIZE};
  write(binding, &info, nullptr);
}

void BindingSet::bind(std::uint32_t binding, const TexelView& view) {
  const VkBufferView handle = view.get();
  write(binding, nullptr, &handle);
}

void BindingSet::bind(std::uint32_t binding, const AccelerationStructure& structure) {
  const VkAccelerationStructureKHR handle = structure.get();
  const VkWriteDescriptorSetAccelerationStructureKHR structures{
      .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR,
      .accelerationStructureCount = 1,
      .pAccelerationStructures = &handle};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .pNext = &structures,
                                   .dstSet = set_,
                                   .dstBinding = binding,
                                   .descriptorCount = 1,
                                   .descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR};
  vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
}

Kernel::Kernel(const Context& context, const PipelineLayout& layout, std::span<const std::uint32_t> spirv,
               std::span<const Specialization> constants, const char* name) {
  const std::vector<std::uint32_t> code = context.modules().specialized(spirv, constants);
  const VkShaderModuleCreateInfo module_info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                             .codeSize = std::span(code).size_bytes(),
                                             .pCode = code.data()};
  VkShaderModule raw_module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(context.device(), &module_info, nullptr, &raw_module),
        fmt::format("load the kernel '{}'", name));
  const Handle<VkShaderModule, &vkDestroyShaderModule> module(context.device(), raw_module);
  const VkPipelineCreateFlags flags =
      context.options().kernel_statistics ? VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR : 0;
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .flags = flags,
                                         .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                   .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                   .module = raw_module,
                                                   .pName = "main"},
                                         .layout = layout.get()};
  VkPipeline pipeline = VK_NULL_HANDLE;
  check(vkCreateComputePipelines(context.device(), context.pipeline_cache(), 1, &info, nullptr, &pipeline),
        fmt::format("compile the kernel '{}'", name));
  pipeline_ = {context.device(), pipeline};
}

namespace {

KernelStatistics::Value value_of(const VkPipelineExecutableStatisticKHR& statistic) {
  switch (statistic.format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
      return {statistic.name, statistic.value.b32 != VK_FALSE};
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
      return {statistic.name, statistic.value.i64};
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
      return {statistic.name, statistic.value.u64};
    default:
      return {statistic.name, statistic.value.f64};
  }
}

}  // namespace

std::vector<KernelStatistics> Kernel::statistics(const Context& context) const {
  constexpr const char* kAction = "read the statistics of a kernel";
  const VkPipelineInfoKHR pipeline{.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, .pipeline = pipeline_.get()};
  std::uint32_t count = 0;
  check(vkGetPipelineExecutablePropertiesKHR(context.device(), &pipeline, &count, nullptr), kAction);
  std::vector<VkPipelineExecutablePropertiesKHR> parts(count,
                                                       {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR});
  check(vkGetPipelineExecutablePropertiesKHR(context.device(), &pipeline, &count, parts.data()), kAction);
  std::vector<KernelStatistics> out;
  for (std::uint32_t i = 0; i < count; ++i) {
    out.push_back({.part = parts[i].name, .subgroup_size = parts[i].subgroupSize});
    const VkPipelineExecutableInfoKHR part{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, .pipeline = pipeline_.get(), .executableIndex = i};
    std::uint32_t values = 0;
    check(vkGetPipelineExecutableStatisticsKHR(context.device(), &part, &values, nullptr), kAction);
    std::vector<VkPipelineExecutableStatisticKHR> statistics(
        values, {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR});
    check(vkGetPipelineExecutableStatisticsKHR(context.device(), &part, &values, statistics.data()), kAction);
    for (const VkPipelineExecutableStatisticKHR& statistic : statistics)
      out.back().values.push_back(value_of(statistic));
  }
  return out;
}

}  // namespace etendue::vulkan
