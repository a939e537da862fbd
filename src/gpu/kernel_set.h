#pragma once
/// Selects the build of the kernels that a renderer uses.

#include <cstdint>
#include <span>
#include <vector>

#include "gpu/device_scene.h"
#include "gpu/gpu_options.h"

namespace etendue {

struct KernelSet {
  std::span<const std::uint32_t> render, take_samples, trace_samples, trace_path, trace_rays,
      bsdf_samples;  ///< SPIR-V words
  std::span<const std::uint32_t> render_plain, trace_samples_plain,
      trace_path_plain;  ///< without the features of shaders/features.glsl
  std::span<const std::uint32_t> profile,
      profile_subgroups;                          ///< the render kernel that counts, see shaders/profile.glsl
  std::vector<vulkan::Specialization> constants;  ///< to be added to those of the scene
};

/// Whether a scene with these constants needs none of the features that plain kernels lack.
bool is_plain(std::span<const vulkan::Specialization> constants);

/// The kernels that render pictures.
KernelSet kernel_set(TableLoads loads);
/// The kernels for traversal by the driver, without those with counters.
KernelSet query_kernel_set();
/// The kernels given in the options, or those that their traversal needs.
KernelSet kernel_set(const GpuOptions& options, TableLoads loads);

}  // namespace etendue
