#pragma once
/// The device's tree traversal on its own: the kernel trace_rays.

#include "gpu/gpu_renderer.h"
#include "render/ray_caster.h"

namespace etendue {

/// Opens the device and uploads the scene, compiled unless it is. Throws Error(device, lost).
std::unique_ptr<RayCaster> make_gpu_ray_caster(const SharedScene& scene, const GpuOptions& options = {});

}  // namespace etendue
