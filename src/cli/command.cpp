#include "cli/command.h"

#include <fmt/core.h>

#include "cli/units.h"
#include "core/log.h"
#include "core/parallel.h"
#include "gpu/bsdf_probe.h"
#include "gpu/gpu_renderer.h"
#include "reference/material_probe.h"
#include "reference/reference_renderer.h"
#include "vulkan/context.h"

namespace etendue::cli {

void SceneOptions::add_to(Command& command) {
  command.add_option("-D,--define", overrides, "override a property of the scene, for example -D integrator.nee=false")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
  command.add_flag("--strict", strict, "unknown properties and rejected samples are errors");
}

ReadOptions SceneOptions::read_options() const {
  ReadOptions options;
  options.strict = strict;
  for (const std::string& text : overrides) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw Error(
          ExitCode::usage,
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

namespace {

// The indices in "0,1,1"; empty when the text is anything else. Device names may hold commas, so only numbers make a
// list.
std::vector<std::string> index_list(const std::string& selector) {
  std::vector<std::string> indices;
  std::size_t start = 0;
  while (start <= selector.size()) {
    const std::size_t comma = std::min(selector.find(',', start), selector.size());
    indices.push_back(selector.substr(start, comma - start));
    if (indices.back().empty() || indices.back().find_first_not_of("0123456789") != std::string::npos) return {};
    start = comma + 1;
  }
  return indices;
}

std::vector<std::string> all_devices() {
  std::vector<std::string> gpus, cpus;
  for (const vulkan::DeviceInfo& info : vulkan::list_devices(gpu_context_options())) {
    if (info.missing.empty()) (info.type == "CPU" ? cpus : gpus).push_back(std::to_string(info.index));
  }
  return gpus.empty() ? cpus : gpus;
}

GpuOptions device_options(const std::string& selector, const DeviceOption& option) {
  GpuOptions options;
  options.device = selector;
  options.fixed_samples = option.pass_samples;
  if (!option.timeout.empty()) options.context.max_wait_seconds = parse_duration("--device-timeout", option.timeout);
  return options;
}

RendererFactory device_factory(const std::string& selector, const DeviceOption& option) {
  return [options = device_options(selector, option)](const SharedScene& scene, const RenderSettings& settings) {
    return make_gpu_renderer(scene, settings, options);
  };
}

}  // namespace

RendererFactory DeviceOption::factory() const {
  set_thread_count(threads);
  if (selector == "reference") {
    return [](const SharedScene& scene, const RenderSettings& settings) {
      return make_reference_renderer(scene.scene(), settings);
    };
  }
  return device_factory(selector, *this);
}

BsdfProbeFactory DeviceOption::probe_factory() const {
  set_thread_count(threads);
  if (selector == "reference") return make_reference_bsdf_probe;
  return [options = device_options(selector, *this)](const Bsdf& bsdf) { return make_gpu_bsdf_probe(bsdf, options); };
}

GpuOptions DeviceOption::gpu_options() const {
  set_thread_count(threads);
  if (selector == "reference")
    throw Error(ExitCode::usage, "--device reference is no Vulkan device; name one that 'etendue devices' lists.");
  return device_options(selector, *this);
}

std::vector<RendererFactory> DeviceOption::factories() const {
  const std::vector<std::string> list = selector == "all" ? all_devices() : index_list(selector);
  std::vector<RendererFactory> factories;
  if (list.size() < 2 && selector != "all") {
    factories.push_back(factory());
    return factories;
  }
  if (list.empty())
    throw Error(ExitCode::no_device,
                "No suitable Vulkan device for '--device all'; see 'etendue devices', or use --device reference.");
  set_thread_count(threads);
  factories.reserve(list.size());
  for (const std::string& index : list) factories.push_back(device_factory(index, *this));
  return factories;
}

}  // namespace etendue::cli
