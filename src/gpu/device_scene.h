#pragma once
/// A compiled scene in device memory, bound for the kernels.

#include "compile/compiled_scene.h"
#include "vulkan/commands.h"

namespace etendue {

/// Bindings of every kernel, as shaders/gpu_types.h numbers them.
std::vector<vulkan::Binding> kernel_bindings();

class DeviceScene {
 public:
  /// Throws Error(device_lost) naming limit, needed and available when a buffer is larger than the device can bind.
  DeviceScene(const vulkan::Context& context, vulkan::Commands& commands, const CompiledScene& scene);
  void bind(vulkan::BindingSet& set) const;

 private:
  struct Entry {
    std::uint32_t binding;
    vulkan::Buffer buffer;
  };
  std::vector<Entry> entries_;
};

}  // namespace etendue
