#pragma once
/// A view in device memory: the constants of a render and its reconstruction filter.

#include "compile/compiled_view.h"
#include "gpu/gpu_device.h"
#include "vulkan/kernel.h"

namespace etendue {

class DeviceView {
 public:
  explicit DeviceView(GpuDevice& device);
  /// Replaces the previous view, in the same buffers.
  void set(GpuDevice& device, const CompiledView& view);
  void bind(vulkan::BindingSet& set) const;

 private:
  vulkan::Buffer frame_, filter_;
  vulkan::TexelView filter_view_;
};

}  // namespace etendue
