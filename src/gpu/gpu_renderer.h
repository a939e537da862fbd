#pragma once
/// The device path: compiles a scene, uploads it and dispatches sample passes.

#include <memory>
#include <optional>
#include <string>

#include "gpu/device_scene.h"
#include "render/renderer.h"
#include "render/shared_scene.h"

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

/// Opens the device and uploads the scene, compiled unless it is; looks at it as the scene says. Throws
/// Error(device, lost).
std::unique_ptr<Renderer> make_gpu_renderer(const SharedScene& scene, const RenderSettings& settings,
                                            const GpuOptions& options = {});
/// Renders a scene that lies on a device already; renderers of one device take turns. `options` must be those of the
/// device scene.
std::unique_ptr<Renderer> make_gpu_renderer(std::shared_ptr<const DeviceScene> scene, const View& view,
                                            const RenderSettings& settings, const GpuOptions& options = {});

/// Timings of a renderer made by make_gpu_renderer.
GpuTimings gpu_timings(const Renderer& renderer);
/// What the render kernel does with samples [0, samples) of every pixel, counted by a build of it that is slower for
/// it.
RenderProfile gpu_profile(Renderer& renderer, std::uint32_t samples);
/// The sentence that says which device was taken and why.
std::string gpu_device_choice(const Renderer& renderer);

}  // namespace etendue
