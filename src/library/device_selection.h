#pragma once
/// The meaning of device selectors.

#include <string>
#include <vector>

#include "etendue/render.h"
#include "gpu/gpu_renderer.h"
#include "render/bsdf_probe.h"

namespace etendue {

/// The selectors of single devices that a selector stands for: several for "0,1,1" and "all", which leaves out CPU
/// drivers if there is anything else. Throws Error(device) if "all" finds none.
std::vector<std::string> single_devices(const std::string& selector);

/// The selectors of all usable devices, including CPU drivers. Throws Error(device) if there is none.
std::vector<std::string> usable_devices();

/// Options of the Vulkan renderer on the device with this selector, which must be a single one.
GpuOptions gpu_options(const DeviceSelection& device);

/// Materials on the device with this selector, which must be a single one.
BsdfProbeFactory bsdf_probe_factory(const DeviceSelection& device);

}  // namespace etendue
