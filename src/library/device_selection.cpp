#include "library/device_selection.h"

#include <algorithm>

#include <fmt/core.h>

#include "core/errors.h"
#include "gpu/bsdf_probe.h"
#include "reference/material_probe.h"
#include "reference/reference_renderer.h"
#include "scene/invariants.h"
#include "vulkan/context.h"

namespace etendue {
namespace {

constexpr const char* kReference = "reference";

// The numbers in "0,1,1"; empty for any other text. Device names may contain commas, so only numbers form a list.
std::vector<std::string> number_list(const std::string& selector) {
  std::vector<std::string> numbers;
  std::size_t start = 0;
  while (start <= selector.size()) {
    const std::size_t comma = std::min(selector.find(',', start), selector.size());
    numbers.push_back(selector.substr(start, comma - start));
    if (numbers.back().empty() || numbers.back().find_first_not_of("0123456789") != std::string::npos) return {};
    start = comma + 1;
  }
  return numbers;
}

struct UsableDevices {
  std::vector<std::string> gpus, cpus;
};

UsableDevices find_usable_devices() {
  UsableDevices usable;
  for (const vulkan::DeviceInfo& info : vulkan::list_devices(gpu_context_options())) {
    if (info.missing.empty()) (info.type == "CPU" ? usable.cpus : usable.gpus).push_back(std::to_string(info.index));
  }
  if (usable.gpus.empty() && usable.cpus.empty())
    throw Error(ErrorKind::device,
                "No suitable Vulkan device for '--device all'; see 'etendue devices', or use --device reference.");
  return usable;
}

}  // namespace

std::vector<std::string> usable_devices() {
  UsableDevices usable = find_usable_devices();
  usable.gpus.insert(usable.gpus.end(), usable.cpus.begin(), usable.cpus.end());
  return usable.gpus;
}

std::vector<std::string> single_devices(const std::string& selector) {
  if (selector == "all") {
    UsableDevices usable = find_usable_devices();
    return usable.gpus.empty() ? usable.cpus : usable.gpus;
  }
  std::vector<std::string> numbers = number_list(selector);
  if (numbers.size() < 2) return {selector};
  return numbers;
}

GpuOptions gpu_options(const DeviceSelection& device) {
  GpuOptions options;
  options.device = device.selector;
  options.fixed_samples = device.pass_samples;
  options.pass_seconds = device.dispatch_seconds;
  options.traversal = device.traversal;
  if (device.max_wait_seconds) options.context.max_wait_seconds = *device.max_wait_seconds;
  return options;
}

BsdfProbeFactory bsdf_probe_factory(const DeviceSelection& device) {
  if (device.selector == kReference) return make_reference_bsdf_probe;
  return [options = gpu_options(device)](const Scene& patch) { return make_gpu_bsdf_probe(patch, options); };
}

std::vector<DeviceDescription> list_devices() {
  std::vector<DeviceDescription> all;
  for (const vulkan::DeviceInfo& info : vulkan::list_devices(gpu_context_options()))
    all.push_back({info.name, info.type, info.driver, info.missing, info.ray_queries});
  return all;
}

std::vector<RendererFactory> renderer_factories(const DeviceSelection& devices) {
  std::vector<RendererFactory> factories;
  for (const std::string& selector : single_devices(devices.selector)) {
    if (selector == kReference) {
      if (devices.traversal == Traversal::query)
        throw Error(ErrorKind::usage,
                    "The reference has its own tree, and --traversal query is for Vulkan devices; choose another "
                    "--device or leave it out.");
      factories.emplace_back([](const SharedScene& scene, const RenderSettings& settings) {
        return make_reference_renderer(scene.scene(), settings);
      });
      continue;
    }
    DeviceSelection one = devices;
    one.selector = selector;
    factories.emplace_back([options = gpu_options(one)](const SharedScene& scene, const RenderSettings& settings) {
      return make_gpu_renderer(scene, settings, options);
    });
  }
  return factories;
}

std::unique_ptr<Renderer> open_renderer(const SharedScene& scene, const DeviceSelection& device,
                                        const RenderSettings& settings) {
  require_invariants(scene.scene());
  const std::vector<RendererFactory> factories = renderer_factories(device);
  if (factories.size() != 1) {
    throw Error(
        ErrorKind::usage,
        fmt::format("'{}' names {} devices, but a renderer is opened on one; render() shares the work of several.",
                    device.selector, factories.size()));
  }
  return factories.front()(scene, settings);
}

}  // namespace etendue
