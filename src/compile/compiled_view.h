#pragma once
/// View → the constants of a render, in the layouts of shaders/gpu_types.h.

#include <cstdint>
#include <vector>

#include "compile/compiled_scene.h"
#include "scene/view.h"

namespace etendue {

/// The facts about a compiled scene that views depend on.
struct SceneFacts {
  Normalization normalization;
  EnvironmentFacts environment;
  int radiance_exponent = 0;
  Bounds bounds;
  std::uint32_t light_instance_count = 0, distant_light_count = 0;

  explicit SceneFacts(const CompiledScene& scene) : SceneFacts(scene, scene) {}
  /// With other lights than those it was compiled with.
  SceneFacts(const CompiledScene& scene, const CompiledLights& lights)
      : normalization(scene.normalization),
        environment(lights.environment.facts),
        radiance_exponent(lights.radiance_exponent),
        bounds(scene.bounds),
        light_instance_count(static_cast<std::uint32_t>(lights.light_instances.size())),
        distant_light_count(lights.distant_lights) {}
};

struct CompiledView {
  gpu::Frame frame{};
  std::uint32_t camera = gpu::kCameraPinhole;       ///< kCamera*
  bool window = false;                              ///< see kConstantCameraWindow
  std::uint32_t integrator = gpu::kIntegratorPath;  ///< kIntegrator*
  std::uint32_t light_part = gpu::kLightPartAll;    ///< kLightPart*
  std::uint32_t filter = gpu::kFilterBox;           ///< kFilter*
  std::vector<float> filter_knots;                  ///< kFilterSteps + 1 offsets in pixels; empty for the box filter
};

CompiledView compile_view(const SceneFacts& scene, const View& view, std::uint32_t seed);

}  // namespace etendue
