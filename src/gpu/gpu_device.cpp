#include "gpu/gpu_device.h"

namespace etendue {

std::shared_ptr<GpuDevice> open_device(const GpuOptions& options) {
  if (options.open) return std::make_shared<GpuDevice>(options.open);
  return std::make_shared<GpuDevice>(std::make_shared<const vulkan::Context>(options.device, options.context));
}

}  // namespace etendue
