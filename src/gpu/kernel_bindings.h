#pragma once
/// Bindings of kernels: set 0 holds a scene, set 1 a view and the work of a dispatch. The numbers are those of
/// shaders/gpu_types.h; what a device must be able to bind is counted only here.

#include <cstdint>
#include <vector>

#include "gpu/gpu_options.h"
#include "vulkan/kernel.h"

namespace etendue {

/// Buffers of the scene's tables, and with `queries` the acceleration structure.
std::vector<vulkan::Binding> scene_bindings(TableLoads loads, bool queries = false);
/// Set 1 of the kernels that render, and of the one that adds samples to the film.
std::vector<vulkan::Binding> film_bindings();
/// Set 1 of all other kernels: requests and results.
std::vector<vulkan::Binding> request_bindings();

/// Bytes of push constants, of every kernel.
std::uint32_t push_constant_bytes();

/// The device requirements of kernels that read tables in this way.
vulkan::Requirements kernel_requirements(TableLoads loads);

/// Set 1 of one kind of kernels, and their pipelines' layout.
struct KernelBindings {
  KernelBindings(const vulkan::Context& context, const vulkan::SetLayout& scene, std::vector<vulkan::Binding> bindings)
      : set(context, std::move(bindings)), pipeline(context, {&scene, &set}, push_constant_bytes()) {}
  vulkan::SetLayout set;
  vulkan::PipelineLayout pipeline;
};

}  // namespace etendue
