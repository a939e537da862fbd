#pragma once
/// The device path: compiles a scene, uploads it and dispatches sample passes.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/device_scene.h"
#include "render/renderer.h"
#include "render/shared_scene.h"
#include "vulkan/kernel.h"

namespace etendue {

/// How the render's time was spent, in seconds.
struct GpuTimings {
  double compile = 0;  ///< scene to buffers, BVH included
  double upload = 0;
  double pipeline = 0;           ///< kernel compilation, including the first dispatch's lazy part
  double render = 0;             ///< dispatches after the first
  std::uint64_t passes = 0;      ///< times the whole film was brought to a later sample
  std::uint64_t dispatches = 0;  ///< after the first
  double longest = 0;            ///< of these, seconds
};

/// Rays of one class and the records they visited.
struct RayCounts {
  std::uint64_t rays = 0, nodes = 0, primitives = 0;
};

/// What the driver's compiler says of a kernel.
struct KernelReport {
  std::string kernel;
  std::vector<vulkan::KernelStatistics> parts;
};

struct RenderProfile {
  std::uint32_t width = 0, height = 0;
  std::uint32_t samples = 0;  ///< of each pixel, paths of sets counted one by one
  RayCounts camera, scattered, shadow;
  /// Fraction of a subgroup's lanes that are active when any is; empty if the device cannot tell.
  std::optional<double> walk_utilisation, shade_utilisation;
  std::vector<glm::vec3> visits;  ///< of each pixel, per sample: nodes, primitives, rays
};

/// Opens the device and uploads the scene, which is compiled unless that is done already; the view is the scene's own.
/// Throws Error(device, lost).
std::unique_ptr<Renderer> make_gpu_renderer(const SharedScene& scene, const RenderSettings& settings,
                                            const GpuOptions& options = {});
/// Renders a scene that is already on a device; renderers of one device take turns. `options` must be those of the
/// device scene.
std::unique_ptr<Renderer> make_gpu_renderer(std::shared_ptr<const DeviceScene> scene, const View& view,
                                            const RenderSettings& settings, const GpuOptions& options = {});

/// Timings of a renderer made by make_gpu_renderer.
GpuTimings gpu_timings(const Renderer& renderer);
/// Counts the operations of the render kernel for samples [0, samples) of every pixel, using a slower build with
/// counters.
RenderProfile gpu_profile(Renderer& renderer, std::uint32_t samples);
/// What the compiler of another device, opened with `kernel_statistics`, makes of the kernels that render the picture.
/// Nothing runs on that device.
std::vector<KernelReport> gpu_kernels(const Renderer& renderer, const vulkan::Context& compiler);
/// The message that says which device was chosen, and why.
std::string gpu_device_choice(const Renderer& renderer);

}  // namespace etendue
