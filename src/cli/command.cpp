#include "cli/command.h"

#include <fmt/core.h>

#include "cli/units.h"
#include "core/log.h"
#include "core/parallel.h"
#include "library/device_selection.h"

namespace etendue::cli {

namespace {

constexpr const char* kScene = "Scene";
constexpr const char* kDevice = "Device";

}  // namespace

void SceneOptions::add_to(Command& command) {
  command.add_option("-D,--define", overrides, "override a property of the scene, for example -D integrator.nee=false")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false)
      ->group(kScene);
  command.add_flag("--strict", strict, "unknown properties and rejected samples are errors")->group(kScene);
  command
      .add_option("--environment", environment, "latitude-longitude picture that lights the scene instead of its sky")
      ->file({".exr", ".hdr", ".png", ".jpg"})
      ->group(kScene);
  command
      .add_option("--camera", camera,
                  "position and target of the camera, optionally with a field of view; for a glTF asset also the name "
                  "or number of one of its cameras")
      ->type_name("X,Y,Z,X,Y,Z[,FOV]")
      ->group(kScene);
  command
      .add_option(
          "--at", at,
          "the time at which to show a camera with keyframes or the animations of a glTF asset, for example 1.5s")
      ->type_name("TIME")
      ->group(kScene);
  command
      .add_option("--animation", animation, "name or number of the animation of a glTF asset to play (default: all)")
      ->type_name("NAME")
      ->group(kScene);
  command.add_option("--scene", scene, "name or number of the scene of a glTF asset")->type_name("NAME")->group(kScene);
  command.add_option("--variant", variant, "name of the material variant of a glTF asset")
      ->type_name("NAME")
      ->group(kScene);
  command
      .add_option("--lamps", lamps,
                  "brightness of a glTF asset's lamps: 'standard', as in the file; 'blender', divided by 683; 'watts', "
                  "points and spots divided by 4 pi; or 'auto', depending on the program that wrote the file")
      ->type_name("RULE")
      ->check(one_of({"auto", "blender", "standard", "watts"}))
      ->capture_default_str()
      ->group(kScene);
  command
      .add_flag("--approximate", approximate,
                "replace whatever the scene asks for but Etendue does not have, with a warning for each")
      ->group(kScene);
}

namespace {

GltfLamps lamps_of(const std::string& rule) {
  if (rule == "blender") return GltfLamps::blender;
  if (rule == "watts") return GltfLamps::watts;
  return rule == "standard" ? GltfLamps::standard : GltfLamps::automatic;
}

}  // namespace

ReadOptions SceneOptions::read_options() const {
  ReadOptions options;
  options.strict = strict;
  options.approximate = approximate;
  options.environment = environment;
  options.camera = camera;
  if (!at.empty()) options.at = parse_moment("--at", at);
  options.scene = scene;
  options.animation = animation;
  options.variant = variant;
  options.lamps = lamps_of(lamps);
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw Error(
          ErrorKind::usage,
          fmt::format("'-D {}' has no '='; write -D tag.property=value, for example -D sampler.sampleCount=64.", text));
    }
    options.overrides.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return options;
}

void SampleOptions::add_to(Command& command) {
  add_size_and_spp(command);
  command.add_option("--seed", seed, "seed of the random numbers")->capture_default_str();
}

void SampleOptions::add_size_and_spp(Command& command) {
  command.add_option("--size", size, "size of the picture in pixels instead of the scene's")->type_name("WxH");
  command.add_option("--spp", spp, "samples per pixel instead of the scene's sampleCount")
      ->check(in_range(1u, 0xffffffffu));
}

void SampleOptions::set_size(Scene& scene) const {
  if (size.empty()) return;
  const Size pixels = parse_size(size);
  scene.camera.width = pixels.width;
  scene.camera.height = pixels.height;
}

void SampleOptions::set_size_and_spp(Scene& scene) const {
  set_size(scene);
  if (spp > 0) scene.sampler.sample_count = spp;
}

void DeviceOption::add_to(Command& command, bool several) {
  const std::string one =
      "the device to render with: auto (the fastest kind available), a number or part of a name from 'etendue "
      "devices', or reference, the double-precision CPU renderer";
  command
      .add_option("--device", selector,
                  several ? one + "; several numbers separated by commas (0,1), or all, share the work" : one)
      ->type_name("DEVICE")
      ->suggest(several ? std::vector<std::string>{"auto", "all", "reference"}
                        : std::vector<std::string>{"auto", "reference"})
      ->capture_default_str()
      ->group(kDevice);
  command
      .add_option("--device-timeout", timeout,
                  "a device whose dispatch takes longer counts as hanging (default and maximum: 5m)")
      ->type_name("TIME")
      ->group(kDevice);
  command
      .add_option("--dispatch-time", dispatch_time,
                  "the longest that a dispatch should take (default: 100ms on GPUs, 1s on CPUs); shorter ones leave a "
                  "GPU that also drives the screen more responsive")
      ->type_name("TIME")
      ->group(kDevice);
  command.add_option("--pass-samples", pass_samples, "samples of each lane per dispatch; for tests")->group("");
  command
      .add_option("--traversal", traversal,
                  "how ray hits are found: tree, Etendue's own, on any device; query, the driver's acceleration "
                  "structures, on devices with VK_KHR_ray_query; auto is tree")
      ->type_name("HOW")
      ->check(one_of({"auto", "tree", "query"}))
      ->capture_default_str()
      ->group(kDevice);
  command.add_option("--threads", threads, "number of host threads; 0: one per core")
      ->check(in_range(0, 1024))
      ->capture_default_str()
      ->group(kDevice);
}

DeviceSelection DeviceOption::selection() const {
  set_thread_count(threads);
  DeviceSelection devices{.selector = selector, .pass_samples = pass_samples};
  devices.traversal = traversal == "query"  ? Traversal::query
                      : traversal == "tree" ? Traversal::tree
                                            : Traversal::automatic;
  if (!timeout.empty()) devices.max_wait_seconds = parse_duration("--device-timeout", timeout);
  if (!dispatch_time.empty()) devices.dispatch_seconds = parse_duration("--dispatch-time", dispatch_time);
  return devices;
}

RendererFactory DeviceOption::factory() const {
  std::vector<RendererFactory> factories = renderer_factories(selection());
  if (factories.size() == 1) return factories.front();
  throw Error(ErrorKind::usage,
              fmt::format("'--device {}' names {} devices; this command takes one.", selector, factories.size()));
}

BsdfProbeFactory DeviceOption::probe_factory() const {
  return bsdf_probe_factory(selection());
}

GpuOptions DeviceOption::gpu_options() const {
  const DeviceSelection device = selection();
  if (selector == "reference")
    throw Error(ErrorKind::usage, "--device reference is not a Vulkan device; name one that 'etendue devices' lists.");
  return etendue::gpu_options(device);
}

std::vector<RendererFactory> DeviceOption::factories() const {
  return renderer_factories(selection());
}

std::vector<LabelledFactory> DeviceOption::compared() const {
  DeviceSelection one = selection();
  std::vector<LabelledFactory> devices;
  for (const std::string& each : selector == "all" ? usable_devices() : single_devices(selector)) {
    one.selector = each;
    devices.push_back({each, renderer_factories(one).front()});
  }
  if (devices.size() == 1) devices.front().label = kOnlyDeviceLabel;
  return devices;
}

}  // namespace etendue::cli
