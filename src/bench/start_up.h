#pragma once
/// The cost until the first sample: tree, upload, compilation of the kernel, and memory.

#include <cstdint>
#include <optional>

#include "gpu/gpu_renderer.h"

namespace etendue {

/// One opening of a device for a scene, up to the first samples of an 8 × 8 film.
struct StartUp {
  double compile = 0;  ///< seconds: scene to buffers, the tree included
  double upload = 0;
  double pipeline = 0;  ///< creating the kernel and its first dispatch of 64 samples: drivers compile lazily
  std::optional<std::uint64_t> host_peak;  ///< bytes the process grew by at most; a CPU driver's buffers are among them
};

/// The size of the film of a start-up.
inline constexpr std::uint32_t kStartUpPixels = 8;

/// Opens a device afresh, which only takes effect while none is open. `cold`: without the pipeline cache, and without
/// those caches of Mesa's and NVIDIA's drivers that can be switched off.
StartUp measure_start_up(Scene scene, GpuOptions options, bool cold);

}  // namespace etendue
