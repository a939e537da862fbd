#pragma once
/// The interface through which main finds the commands: each file of this folder adds one.

#include <functional>
#include <string>
#include <vector>

#include "cli/ending.h"
#include "core/command_line.h"
#include "etendue/render.h"
#include "formats/read_scene.h"
#include "gpu/gpu_renderer.h"
#include "render/bsdf_probe.h"
#include "validate/renderer_factory.h"

namespace etendue::cli {

/// Set by the parsed subcommand; run by main after the options were read.
using Action = std::function<Result()>;

void add_render_command(Command& app, Action& action);
void add_devices_command(Command& app, Action& action);
void add_check_command(Command& app, Action& action);
void add_ttest_command(Command& app, Action& action);
void add_convert_command(Command& app, Action& action);
void add_merge_command(Command& app, Action& action);
void add_denoise_command(Command& app, Action& action);
void add_compare_command(Command& app, Action& action);
void add_validate_command(Command& app, Action& action);
void add_chi2_command(Command& app, Action& action);
void add_selftest_command(Command& app, Action& action);
void add_bench_command(Command& app, Action& action);
void add_explain_command(Command& app, Action& action);
void add_view_command(Command& app, Action& action);

/// The endings of scene files, for shell completion.
inline const std::vector<std::string> kSceneEndings = {".xml", ".gltf", ".glb", ".obj", ".ply"};

/// Options that several commands share.
struct SceneOptions {
  std::vector<std::string> overrides;  ///< "integrator.nee=false"
  bool strict = false;
  bool approximate = false;
  std::string environment, camera, at, scene, animation, variant;
  std::string lamps = "auto";

  void add_to(Command& command);
  /// Throws Error(usage) for an override without '='.
  ReadOptions read_options() const;
};

/// --size and --spp, short for properties of the scene, and --seed: alike in every command that renders.
struct SampleOptions {
  std::string size;       ///< "WxH"; empty: the scene's
  std::uint32_t spp = 0;  ///< 0: the default of the scene or the command
  std::uint32_t seed = 0;

  void add_to(Command& command);
  /// --size and --spp, for commands without random numbers of their own.
  void add_size_and_spp(Command& command);
  /// Sets the camera's size, if one was given. Throws Error(usage).
  void set_size(Scene& scene) const;
  /// The same, and sets the sampler's number of samples.
  void set_size_and_spp(Scene& scene) const;
};

struct DeviceOption {
  std::string selector = "auto";
  std::string timeout;             ///< of one dispatch, "30s"; empty: the default of vulkan::ContextOptions
  std::string dispatch_time;       ///< "20ms"; empty: the device's default
  std::uint32_t pass_samples = 0;  ///< see GpuOptions::fixed_samples; for tests
  std::string traversal = "auto";
  unsigned threads = 0;  ///< of the reference and of scene compilation; 0: as many as there are cores

  /// `several`: whether the command shares its work among devices.
  void add_to(Command& command, bool several = false);
  /// The selection for the library. Also sets the number of threads.
  DeviceSelection selection() const;
  /// Renderers on the chosen device; "reference" is the CPU reference.
  RendererFactory factory() const;
  /// Materials on the chosen device.
  BsdfProbeFactory probe_factory() const;
  /// The chosen Vulkan device. Throws Error(usage) for "reference".
  GpuOptions gpu_options() const;
  /// One factory per device if the selector names several. Throws Error(usage, device).
  std::vector<RendererFactory> factories() const;
  /// The selectors of the devices to be compared; here "all" includes CPU drivers. Throws Error(usage, device).
  std::vector<LabelledFactory> compared() const;
};

}  // namespace etendue::cli
