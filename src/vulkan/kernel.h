#pragma once
/// Compute pipelines over one shared descriptor layout.

#include <cstdint>
#include <span>
#include <vector>

#include "vulkan/buffer.h"

namespace etendue::vulkan {

/// One binding of set 0.
struct Binding {
  std::uint32_t number = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
};

/// Descriptor set layout and pipeline layout shared by all kernels of a renderer.
class BindingLayout {
 public:
  BindingLayout(const Context& context, std::span<const Binding> bindings, std::uint32_t push_constant_bytes);
  VkDescriptorSetLayout set_layout() const { return set_layout_.get(); }
  VkPipelineLayout pipeline_layout() const { return pipeline_layout_.get(); }
  std::uint32_t push_constant_bytes() const { return push_constant_bytes_; }
  const std::vector<Binding>& bindings() const { return bindings_; }

 private:
  std::vector<Binding> bindings_;
  std::uint32_t push_constant_bytes_;
  Handle<VkDescriptorSetLayout, &vkDestroyDescriptorSetLayout> set_layout_;
  Handle<VkPipelineLayout, &vkDestroyPipelineLayout> pipeline_layout_;
};

/// Buffers bound to a layout.
class BindingSet {
 public:
  BindingSet(const Context& context, const BindingLayout& layout);
  void bind(std::uint32_t binding, const Buffer& buffer);
  void bind(std::uint32_t binding, const TexelView& view);
  VkDescriptorSet get() const { return set_; }

 private:
  void write(std::uint32_t binding, const VkDescriptorBufferInfo* buffer, const VkBufferView* view);
  VkDevice device_;
  const BindingLayout* layout_;
  Handle<VkDescriptorPool, &vkDestroyDescriptorPool> pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

/// Value of `layout(constant_id = id)`.
struct Specialization {
  std::uint32_t id = 0;
  std::uint32_t value = 0;
  bool operator==(const Specialization&) const = default;
};

class Kernel {
 public:
  Kernel() = default;
  Kernel(const Context& context, const BindingLayout& layout, std::span<const std::uint32_t> spirv,
         std::span<const Specialization> constants, const char* name);
  VkPipeline get() const { return pipeline_.get(); }

 private:
  Handle<VkPipeline, &vkDestroyPipeline> pipeline_;
};

}  // namespace etendue::vulkan
