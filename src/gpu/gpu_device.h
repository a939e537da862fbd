#pragma once
/// An open device, with everything that its users share.

#include <memory>

#include "gpu/gpu_options.h"
#include "vulkan/commands.h"

namespace etendue {

/// Used by one thread at a time. Objects in its memory keep it alive.
struct GpuDevice {
  explicit GpuDevice(std::shared_ptr<const vulkan::Context> open) : context(std::move(open)), commands(*context) {}

  std::shared_ptr<const vulkan::Context> context;
  vulkan::Commands commands;
};

/// The open device given in the options, otherwise the one that they name. Throws Error(device, lost).
std::shared_ptr<GpuDevice> open_device(const GpuOptions& options);

}  // namespace etendue
