#pragma once
/// A compiled scene in device memory, bound for the kernels.

#include "compile/compiled_scene.h"
#include "vulkan/commands.h"
#include "vulkan/kernel.h"

namespace etendue {

/// Bindings of every kernel, as shaders/gpu_types.h numbers them.
std::vector<vulkan::Binding> kernel_bindings();

/// Rounds of the two bisections that choose a light: ceil(log2) of what there is to choose from.
struct LightRounds {
  std::uint32_t shapes = 0, primitives = 0;
  explicit LightRounds(const CompiledScene& scene);
};

/// Specialization constants of every kernel that traces rays: tree depth, lights, and the primitives of a scene of few.
std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene);

class DeviceScene {
 public:
  /// Throws Error(device_lost) naming limit, needed and available when a table is larger than the device can read.
  DeviceScene(const vulkan::Context& context, vulkan::Commands& commands, const CompiledScene& scene);
  void bind(vulkan::BindingSet& set) const;

 private:
  struct Entry {
    std::uint32_t binding;
    vulkan::Buffer buffer;
    vulkan::TexelView view;  // of a table
  };
  vulkan::Buffer upload(std::span<const std::byte> bytes, VkBufferUsageFlags usage, const char* what);
  void add_uniform(std::uint32_t binding, std::span<const std::byte> bytes, const char* what);
  void add_table(std::uint32_t binding, std::span<const std::byte> bytes, const char* what);

  const vulkan::Context& context_;
  vulkan::Commands& commands_;
  std::vector<Entry> entries_;
};

}  // namespace etendue
