#pragma once
/// The device path: compiles a scene, uploads it and dispatches sample passes.

#include <memory>
#include <optional>
#include <string>

#include "gpu/device_scene.h"
#include "render/renderer.h"
#include "vulkan/context.h"

namespace etendue {

/// Where the render's time went, in seconds.
struct GpuTimings {
  double compile = 0;  ///< scene to buffers, BVH included
  double upload = 0;
  double pipeline = 0;           ///< kernel compilation, the first dispatch's lazy part included
  double render = 0;             ///< dispatches after the first
  std::uint64_t passes = 0;      ///< times the whole film was brought to a later sample
  std::uint64_t dispatches = 0;  ///< after the first
  double longest = 0;            ///< of these, seconds
};

/// Rays of one class and what they visited.
struct RayCounts {
  std::uint64_t rays = 0, nodes = 0, primitives = 0;
};

struct RenderProfile {
  std::uint32_t width = 0, height = 0;
  std::uint32_t samples = 0;  ///< of each pixel, paths of sets counted one by one
  RayCounts camera, scattered, shadow;
  /// Lanes of a subgroup that work when any does, as a fraction; nothing where the device cannot tell.
  std::optional<double> walk_utilisation, shade_utilisation;
  std::vector<glm::vec3> visits;  ///< of each pixel, per sample: nodes, primitives, rays
};

struct GpuOptions {
  std::string device = "auto";  ///< see vulkan::Context
  vulkan::ContextOptions context = vulkan::ContextOptions::from_environment();
  double pass_seconds = 0.1;        ///< a dispatch is sized to take about this long, so that no watchdog fires
  std::uint32_t fixed_samples = 0;  ///< not 0: samples of each slot per dispatch, for tests of the equality contract
  std::uint32_t fixed_groups = 0;   ///< not 0: workgroups per dispatch
  std::optional<TableLoads> loads;  ///< see choose_table_loads; for tests and measurements
  std::optional<std::uint32_t>
      mutant;  ///< kernels with a planted error (shaders/mutants.h), for tests of the tests; 0: those kernels, no error

  /// The choice of `loads` that is open: kernels with planted errors read texel buffers only.
  std::optional<TableLoads> wanted_loads() const { return mutant ? TableLoads::texel_buffer : loads; }
};

/// Opens the device and uploads the scene. Throws Error(no_device, device_lost).
std::unique_ptr<Renderer> make_gpu_renderer(const Scene& scene, const RenderSettings& settings,
                                            const GpuOptions& options = {});

/// Timings of a renderer made by make_gpu_renderer.
GpuTimings gpu_timings(const Renderer& renderer);
/// What the render kernel does with samples [0, samples) of every pixel, counted by a build of it that is slower for
/// it.
RenderProfile gpu_profile(Renderer& renderer, std::uint32_t samples);
/// The sentence that says which device was taken and why.
std::string gpu_device_choice(const Renderer& renderer);

}  // namespace etendue
