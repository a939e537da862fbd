#pragma once
/// An open device with what all its work shares.

#include <memory>

#include "gpu/gpu_options.h"
#include "vulkan/commands.h"

namespace etendue {

/// Used by one thread at a time. Whatever lives in its memory holds it.
struct GpuDevice {
  explicit GpuDevice(std::shared_ptr<const vulkan::Context> open) : context(std::move(open)), commands(*context) {}

  std::shared_ptr<const vulkan::Context> context;
  vulkan::Commands commands;
};

/// The device that the options hand over, or else the one they name. Throws Error(device, lost).
std::shared_ptr<GpuDevice> open_device(const GpuOptions& options);

}  // namespace etendue
