#include "gpu/gpu_device.h"

#include "gpu/kernel_bindings.h"

namespace etendue {

vulkan::ContextOptions gpu_context_options() {
  vulkan::ContextOptions options = vulkan::ContextOptions::from_environment();
  options.requirements = kernel_requirements(TableLoads::texel_buffer);
  return options;
}

std::shared_ptr<GpuDevice> open_device(const GpuOptions& options) {
  if (options.open) return std::make_shared<GpuDevice>(options.open);
  return std::make_shared<GpuDevice>(std::make_shared<const vulkan::Context>(options.device, options.context));
}

}  // namespace etendue
