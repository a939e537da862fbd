#include <charconv>
#include <chrono>

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/progress.h"
#include "core/log.h"
#include "core/version.h"
#include "gpu/gpu_renderer.h"
#include "image/image.h"

namespace etendue::cli {
namespace {

struct Options {
  std::string scene_file;
  SceneOptions scene;
  DeviceOption device;
  std::vector<std::string> outputs;
  std::uint32_t spp = 0;
  std::uint32_t seed = 0;
  std::string size;
  bool quiet = false;
  bool json = false;
};

void apply_size(const std::string& text, Camera& camera) {
  const std::size_t x = text.find('x');
  std::uint32_t size[2] = {0, 0};
  const std::string parts[2] = {text.substr(0, x), x == std::string::npos ? "" : text.substr(x + 1)};
  for (int i = 0; i < 2; ++i) {
    const char* end = parts[i].data() + parts[i].size();
    const auto [stop, error] = std::from_chars(parts[i].data(), end, size[i]);
    if (error != std::errc{} || stop != end || size[i] == 0 || size[i] > 65536) {
      throw Error(ExitCode::usage, fmt::format("'--size {}' is not WIDTHxHEIGHT in pixels from 1 to 65536; write for example --size 800x600.", text));
    }
  }
  camera.width = size[0];
  camera.height = size[1];
}

std::string integrator_text(const Integrator& integrator) {
  if (integrator.type == Integrator::Type::normals) return "normals";
  return fmt::format("path maxDepth={} nee={} mis={} rrDepth={}", integrator.max_depth, integrator.nee, integrator.mis, integrator.rr_depth);
}

Metadata make_metadata(const Scene& scene, const Renderer& renderer, const Options& options, SampleRange range, std::uint64_t rejected) {
  return {{"software", "Etendue"},
          {"version", version()},
          {"scene", scene.name},
          {"sceneHash", fmt::format("{:016x}", scene_hash(scene))},
          {"device", renderer.device_name()},
          {"driver", renderer.driver_name()},
          {"seed", std::to_string(options.seed)},
          {"samples", fmt::format("{}:{}", range.begin, range.end)},
          {"integrator", integrator_text(scene.integrator)},
          {"rejected", std::to_string(rejected)}};
}

void report_rejected(const std::vector<RejectedSample>& rejected, std::uint64_t count, std::uint32_t width, bool strict) {
  if (count == 0) return;
  std::string places;
  for (std::size_t i = 0; i < std::min<std::size_t>(rejected.size(), 4); ++i) {
    const RejectedSample& r = rejected[i];
    places += fmt::format("{} pixel ({}, {}) sample {} segment {}", i == 0 ? ":" : ";", r.id.pixel % width, r.id.pixel / width, r.id.sample, r.segments);
  }
  const std::string text = fmt::format("{} samples were not finite or too large for the film and were left out{}", count, places);
  if (strict) throw Error(ExitCode::test_failed, text + "; without --strict the image is written without them.");
  log::warning(text);
}

void write_outputs(const Film& film, const Metadata& metadata, const std::vector<std::string>& outputs) {
  const Image image = image_from_film(film, metadata);
  for (const std::string& path : outputs) {
    if (path.ends_with(".png")) {
      write_png(path, image);
    } else {
      write_exr(path, image);
    }
  }
}

std::vector<std::string> output_paths(const Options& options, const Scene& scene) {
  if (options.outputs.empty()) return {scene.name + ".exr", scene.name + ".png"};
  for (const std::string& path : options.outputs) {
    if (!path.ends_with(".exr") && !path.ends_with(".png")) {
      throw Error(ExitCode::usage, fmt::format("'-o {}' ends neither in .exr nor in .png, the two formats that are written.", path));
    }
  }
  return options.outputs;
}

ExitCode render(const Options& options) {
  Scene scene = read_scene(options.scene_file, options.scene.read_options());
  if (!options.size.empty()) apply_size(options.size, scene.camera);
  const SampleRange range{0, options.spp > 0 ? options.spp : scene.sampler.sample_count};
  const std::vector<std::string> outputs = output_paths(options, scene);

  const auto start = std::chrono::steady_clock::now();
  const auto renderer = options.device.factory()(scene, {.seed = options.seed});
  if (!options.quiet && options.device.selector != "reference") log::info(gpu_device_choice(*renderer));
  Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
  std::vector<RejectedSample> rejected;
  const auto render_start = std::chrono::steady_clock::now();
  {
    ProgressLine line(options.quiet);
    renderer->render(range, film, [&](std::uint64_t done, std::uint64_t total) { line.update(done, total); return true; }, rejected);
  }
  const auto end = std::chrono::steady_clock::now();
  report_rejected(rejected, film.rejected(), film.width(), options.scene.strict);
  const Metadata metadata = make_metadata(scene, *renderer, options, range, film.rejected());
  write_outputs(film, metadata, outputs);

  const double render_seconds = std::chrono::duration<double>(end - render_start).count();
  const double samples = static_cast<double>(range.count()) * film.width() * film.height();
  if (options.json) {
    nlohmann::json out = {{"outputs", outputs}, {"metadata", metadata}, {"seconds", std::chrono::duration<double>(end - start).count()},
                          {"render_seconds", render_seconds}, {"samples_per_second", samples / render_seconds}, {"rejected", film.rejected()}};
    if (options.device.selector != "reference") {
      const GpuTimings t = gpu_timings(*renderer);
      out["timings"] = {{"compile", t.compile}, {"upload", t.upload}, {"pipeline", t.pipeline}, {"render", t.render}};
    }
    fmt::print("{}\n", out.dump(2));
  } else if (!options.quiet) {
    log::info(fmt::format("Rendered {}x{} at {} spp in {} ({:.2f} Msamples/s); wrote {}.", film.width(), film.height(), range.count(),
                          duration_text(render_seconds), samples / render_seconds * 1e-6, fmt::join(outputs, " and ")));
  }
  return ExitCode::ok;
}

}  // namespace

void add_render_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("render", "render a scene to EXR and PNG");
  const auto options = std::make_shared<Options>();
  command->add_option("SCENE", options->scene_file, "scene file")->required();
  command->add_option("-o,--output", options->outputs, "image to write, .exr or .png; may be repeated (default: <scene name>.exr and .png here)")
      ->allow_extra_args(false);
  command->add_option("--spp", options->spp, "samples per pixel instead of the scene's sampleCount")->check(CLI::Range(1u, 0xffffffffu));
  command->add_option("--seed", options->seed, "seed of the random numbers")->capture_default_str();
  command->add_option("--size", options->size, "film size instead of the scene's, WxH");
  options->scene.add_to(*command);
  options->device.add_to(*command);
  command->add_flag("-q,--quiet", options->quiet, "say nothing but errors");
  command->add_flag("--json", options->json, "print what was done as JSON");
  command->callback([&action, options] { action = [options] { return render(*options); }; });
}

}  // namespace etendue::cli
