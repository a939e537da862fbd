#include "cli/command.h"

#include <fmt/core.h>

#include "cli/units.h"
#include "core/log.h"
#include "core/parallel.h"
#include "gpu/bsdf_probe.h"
#include "library/device_selection.h"
#include "reference/material_probe.h"

namespace etendue::cli {

void SceneOptions::add_to(Command& command) {
  command.add_option("-D,--define", overrides, "override a property of the scene, for example -D integrator.nee=false")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  command.add_flag("--strict", strict, "unknown properties and rejected samples are errors");
  command
      .add_option("--environment", environment,
                  "a picture of latitude and longitude that lights the scene in place of its sky")
      ->type_name("FILE");
  command
      .add_option(
          "--camera", camera,
          "where the scene is seen from: the eye and what it looks at, perhaps a field of view; of a glTF asset "
          "also the name or number of one of its cameras")
      ->type_name("X,Y,Z,X,Y,Z[,FOV]");
  command.add_option("--scene", scene, "name or number of the scene of a glTF asset")->type_name("NAME");
  command.add_option("--variant", variant, "name of the material variant of a glTF asset")->type_name("NAME");
  command
      .add_option("--lamps", lamps,
                  "brightness of a glTF asset's lamps: 'standard', as it is written, 'blender', one 683rd of it, or "
                  "'auto', by what wrote the file")
      ->type_name("RULE")
      ->capture_default_str();
  command.add_flag("--approximate", approximate,
                   "what a scene for Mitsuba asks for and there is not here is replaced, with a warning for each");
}

namespace {

GltfLamps lamps_of(const std::string& rule) {
  if (rule == "auto") return GltfLamps::automatic;
  if (rule == "blender") return GltfLamps::blender;
  if (rule == "standard") return GltfLamps::standard;
  throw Error(ErrorKind::usage,
              fmt::format("'--lamps {}': there is no such rule; use auto, blender or standard.", rule));
}

}  // namespace

ReadOptions SceneOptions::read_options() const {
  ReadOptions options;
  options.strict = strict;
  options.approximate = approximate;
  options.environment = environment;
  options.camera = camera;
  options.scene = scene;
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

void DeviceOption::add_to(Command& command) {
  command
      .add_option("--device", selector,
                  "'auto', an index or a part of the name as 'etendue devices' lists them, or 'reference'")
      ->type_name("SEL")
      ->capture_default_str();
  command
      .add_option("--device-timeout", timeout,
                  "a dispatch that takes longer means that the device hangs (default and at most 5m)")
      ->type_name("TIME");
  command.add_option("--pass-samples", pass_samples, "samples of each lane per dispatch; for tests")->group("");
  command.add_option("--threads", threads, "host threads; 0: as many as there are cores")->check(in_range(0, 1024));
}

DeviceSelection DeviceOption::selection() const {
  set_thread_count(threads);
  DeviceSelection devices{.selector = selector, .pass_samples = pass_samples};
  if (!timeout.empty()) devices.max_wait_seconds = parse_duration("--device-timeout", timeout);
  return devices;
}

RendererFactory DeviceOption::factory() const {
  std::vector<RendererFactory> factories = renderer_factories(selection());
  if (factories.size() == 1) return factories.front();
  throw Error(ErrorKind::usage,
              fmt::format("'--device {}' names {} devices; this command takes one.", selector, factories.size()));
}

BsdfProbeFactory DeviceOption::probe_factory() const {
  const DeviceSelection device = selection();
  if (selector == "reference") return make_reference_bsdf_probe;
  return [options = etendue::gpu_options(device)](const Bsdf& bsdf) { return make_gpu_bsdf_probe(bsdf, options); };
}

GpuOptions DeviceOption::gpu_options() const {
  const DeviceSelection device = selection();
  if (selector == "reference")
    throw Error(ErrorKind::usage, "--device reference is no Vulkan device; name one that 'etendue devices' lists.");
  return etendue::gpu_options(device);
}

std::vector<RendererFactory> DeviceOption::factories() const {
  return renderer_factories(selection());
}

}  // namespace etendue::cli
