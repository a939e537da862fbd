#include "cli/command.h"

#include <fmt/core.h>

#include "core/log.h"
#include "core/parallel.h"
#include "gpu/gpu_renderer.h"
#include "reference/reference_renderer.h"

namespace etendue::cli {

void SceneOptions::add_to(CLI::App& command) {
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
      throw Error(ExitCode::usage, fmt::format("'-D {}' has no '='; write -D tag.property=value, for example -D sampler.sampleCount=64.", text));
    }
    options.overrides.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return options;
}

void DeviceOption::add_to(CLI::App& command) {
  command.add_option("--device", selector, "'auto', an index or a part of the name as 'etendue devices' lists them, or 'reference'")
      ->type_name("SEL")
      ->capture_default_str();
  command.add_option("--threads", threads, "host threads; 0: as many as there are cores")->check(CLI::Range(0, 1024));
}

RendererFactory DeviceOption::factory() const {
  set_thread_count(threads);
  if (selector == "reference") return make_reference_renderer;
  return [device = selector](const Scene& scene, const RenderSettings& settings) {
    GpuOptions options;
    options.device = device;
    return make_gpu_renderer(scene, settings, options);
  };
}

}  // namespace etendue::cli
