#pragma once
/// Which device renders, and how its work is divided.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "render/traversal.h"
#include "vulkan/context.h"

namespace etendue {

struct KernelSet;  // kernel_set.h

/// How kernels read the tables of the scene, see shaders/scene.glsl.
enum class TableLoads { texel_buffer, storage_buffer };

/// Context options from the environment, with the requirements of the kernels.
vulkan::ContextOptions gpu_context_options();

struct GpuOptions {
  std::string device = "auto";  ///< see vulkan::Context
  vulkan::ContextOptions context = gpu_context_options();
  std::shared_ptr<const vulkan::Context> open;  ///< if not null, a device that is already open, instead of `device`
  std::optional<double> pass_seconds;  ///< longest that a dispatch should take, instead of the device's default
  std::uint32_t fixed_samples = 0;     ///< not 0: samples of each slot per dispatch, for tests of the equality contract
  std::uint32_t fixed_groups = 0;      ///< not 0: workgroups per dispatch
  std::optional<TableLoads> loads;     ///< see choose_table_loads; for tests and measurements
  std::shared_ptr<const KernelSet>
      kernels;  ///< not null: instead of the kernels that render pictures; they read texel buffers

  Traversal traversal = Traversal::automatic;

  /// Whether the driver traverses.
  bool queries() const { return traversal == Traversal::query; }
  /// The possible choices of `loads`: kernels with ray queries are built for texel buffers only.
  std::optional<TableLoads> wanted_loads() const { return kernels || queries() ? TableLoads::texel_buffer : loads; }
};

}  // namespace etendue
