#pragma once
/// The device's materials for the tests of sampling.

#include "gpu/gpu_renderer.h"
#include "render/bsdf_probe.h"

namespace etendue {

/// Opens the device for the material on a patch. Throws Error(device, lost).
std::unique_ptr<BsdfProbe> make_gpu_bsdf_probe(const Scene& patch, const GpuOptions& options = {});

}  // namespace etendue
