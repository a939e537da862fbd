#pragma once
/// Compute pipelines and their bindings.

#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "vulkan/buffer.h"
#include "vulkan/specialize.h"

namespace etendue::vulkan {

class AccelerationStructure;  // acceleration.h

/// One binding of a descriptor set.
struct Binding {
  std::uint32_t number = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  bool operator==(const Binding&) const = default;
};

/// The layout of a descriptor set.
class SetLayout {
 public:
  SetLayout(const Context& context, std::vector<Binding> bindings);
  VkDescriptorSetLayout get() const { return layout_.get(); }
  const std::vector<Binding>& bindings() const { return bindings_; }

 private:
  std::vector<Binding> bindings_;
  Handle<VkDescriptorSetLayout, &vkDestroyDescriptorSetLayout> layout_;
};

/// The sets 0, 1, … of a kernel, and its push constants.
class PipelineLayout {
 public:
  PipelineLayout(const Context& context, std::initializer_list<const SetLayout*> sets,
                 std::uint32_t push_constant_bytes);
  VkPipelineLayout get() const { return layout_.get(); }

 private:
  Handle<VkPipelineLayout, &vkDestroyPipelineLayout> layout_;
};

/// Buffers bound to a set's layout, which must outlive it.
class BindingSet {
 public:
  BindingSet(const Context& context, const SetLayout& layout);
  void bind(std::uint32_t binding, const Buffer& buffer);
  void bind(std::uint32_t binding, const TexelView& view);
  void bind(std::uint32_t binding, const AccelerationStructure& structure);
  VkDescriptorSet get() const { return set_; }

 private:
  void write(std::uint32_t binding, const VkDescriptorBufferInfo* buffer, const VkBufferView* view);
  VkDevice device_;
  const SetLayout* layout_;
  Handle<VkDescriptorPool, &vkDestroyDescriptorPool> pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

class Kernel {
 public:
  Kernel() = default;
  Kernel(const Context& context, const PipelineLayout& layout, std::span<const std::uint32_t> spirv,
         std::span<const Specialization> constants, const char* name);
  VkPipeline get() const { return pipeline_.get(); }

 private:
  Handle<VkPipeline, &vkDestroyPipeline> pipeline_;
};

}  // namespace etendue::vulkan
