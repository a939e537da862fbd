#pragma once
/// Compute pipelines and their bindings.

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <variant>
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

/// What the driver's compiler says of a part of a kernel, by its own names: registers, spills, code and the like.
struct KernelStatistics {
  struct Value {
    std::string name;
    std::variant<bool, std::int64_t, std::uint64_t, double> value;
  };
  std::string part;
  std::uint32_t subgroup_size = 0;
  std::vector<Value> values;
};

class Kernel {
 public:
  Kernel() = default;
  Kernel(const Context& context, const PipelineLayout& layout, std::span<const std::uint32_t> spirv,
         std::span<const Specialization> constants, const char* name);
  VkPipeline get() const { return pipeline_.get(); }
  /// Of each part that the driver compiled, usually one; for kernels of a context with `kernel_statistics`.
  std::vector<KernelStatistics> statistics(const Context& context) const;

 private:
  Handle<VkPipeline, &vkDestroyPipeline> pipeline_;
};

}  // namespace etendue::vulkan
