#pragma once
/// The device's traversal by itself: the kernel trace_rays.

#include "gpu/gpu_renderer.h"
#include "render/ray_caster.h"

namespace etendue {

/// Opens the device and uploads the scene, which is compiled unless that is done already. Throws Error(device, lost).
std::unique_ptr<RayCaster> make_gpu_ray_caster(const SharedScene& scene, const GpuOptions& options = {});

}  // namespace etendue
