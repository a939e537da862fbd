#include "gpu/gpu_device.h"

#include <fmt/core.h>

#include "core/errors.h"
#include "gpu/kernel_bindings.h"

namespace etendue {

vulkan::ContextOptions gpu_context_options() {
  vulkan::ContextOptions options = vulkan::ContextOptions::from_environment();
  options.requirements = kernel_requirements(TableLoads::texel_buffer);
  return options;
}

std::shared_ptr<GpuDevice> open_device(const GpuOptions& options) {
  if (options.open) {
    if (options.queries() && !options.open->options().requirements.ray_queries)
      throw Error(ErrorKind::device, fmt::format("'{}' was not opened for ray queries; give its context those "
                                                 "requirements, or use the tree.",
                                                 options.open->info().name));
    return std::make_shared<GpuDevice>(options.open);
  }
  vulkan::ContextOptions context = options.context;
  context.requirements.ray_queries |= options.queries();
  return std::make_shared<GpuDevice>(std::make_shared<const vulkan::Context>(options.device, context));
}

}  // namespace etendue
