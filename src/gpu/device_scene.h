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
  void upload_records(const vulkan::Context& context, vulkan::Commands& commands,
                      const std::vector<gpu::Record>& records);

  std::vector<Entry> entries_;
  vulkan::Buffer records_;
  vulkan::TexelView record_view_;
};

}  // namespace etendue
