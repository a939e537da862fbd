#include <algorithm>
#include <filesystem>

#include <fmt/core.h>

#include "bench/export.h"
#include "bench/report.h"
#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "cli/units.h"
#include "core/errors.h"
#include "core/log.h"
#include "core/parallel.h"

namespace etendue::cli {
namespace {

struct BenchArguments {
  std::vector<std::string> files;
  SceneOptions scene;
  DeviceOption device;
  std::uint32_t repetitions = 5;
  std::string time = "1s";
  std::size_t rays = 0;
  SampleOptions sampling;
  std::vector<std::string> parts;
  std::string compiler;
  std::string export_folder;
  std::string loads;
  bool quick = false;
  ResultOptions results;
};

// The settings of --quick: just enough to see that everything works.
constexpr std::size_t kQuickRays = 1 << 14;
constexpr double kQuickSeconds = 0.02;

// The default scenes: one with few primitives, and one with a tree of half a million.
std::vector<std::string> default_scenes() {
  std::vector<std::string> files;
  for (const char* name : {"cbox-sphere", "cbox-bumpy", "bubble"}) {
    const std::filesystem::path path = std::filesystem::path("scenes") / (std::string(name) + ".xml");
    if (!std::filesystem::exists(path))
      throw Error(
          ErrorKind::usage,
          fmt::format("There is no {} here to measure; name scenes, or run this in the source folder.", path.string()));
    files.push_back(path.string());
  }
  return files;
}

BenchOptions bench_options(const BenchArguments& options) {
  BenchOptions out{.rays = options.rays,
                   .seconds = parse_duration("--time", options.time),
                   .spp = options.sampling.spp,
                   .seed = options.sampling.seed};
  if (options.device.selector == "reference") {
    options.device.factory();  // sets the number of threads
  } else {
    out.gpu = options.device.gpu_options();
    if (options.loads == "storage" && out.gpu->queries())
      throw Error(ErrorKind::usage,
                  "Kernels for ray queries read texel buffers; leave out '--loads storage' or use "
                  "--traversal tree.");
    if (!options.loads.empty())
      out.gpu->loads = options.loads == "texel" ? TableLoads::texel_buffer : TableLoads::storage_buffer;
  }
  if (options.quick) {
    out.rays = options.rays > 0 ? options.rays : kQuickRays;
    out.seconds = kQuickSeconds;
  }
  if (!options.parts.empty()) {
    const auto asked = [&](const char* part) { return std::ranges::find(options.parts, part) != options.parts.end(); };
    out.start_up = asked("start");
    out.cast_rays = asked("rays");
    out.render = asked("samples");
    if (asked("kernels")) out.compiler = options.compiler.empty() ? options.device.selector : options.compiler;
  }
  if (!options.compiler.empty() && !out.compiler)
    throw Error(ErrorKind::usage, "'--compiler' is for '--part kernels', which is missing; add it.");
  if (out.compiler && !out.gpu)
    throw Error(ErrorKind::usage, "The reference has no kernels; choose another --device, or another --part.");
  return out;
}

std::vector<std::unique_ptr<SceneBench>> read_scenes(const BenchArguments& options, const BenchOptions& bench) {
  std::vector<std::unique_ptr<SceneBench>> benches;
  for (const std::string& file : options.files.empty() ? default_scenes() : options.files) {
    Scene scene = read_scene(file, options.scene.read_options());
    options.sampling.set_size(scene);
    benches.push_back(std::make_unique<SceneBench>(std::move(scene), bench));
  }
  return benches;
}

// Each scene gets a folder of its own, named after it.
void export_all(const std::string& folder, const std::vector<std::unique_ptr<SceneBench>>& benches) {
  for (const auto& bench : benches) {
    const std::string place = (std::filesystem::path(folder) / bench->scene().name).string();
    export_scene(bench->scene(), place);
    if (!bench->ray_sets().empty())
      export_rays(bench->scene(), bench->placement(), bench->ray_sets(), bench->hits(), place + "/rays.bin");
  }
}

Ending run_bench(const BenchArguments& options) {
  options.results.begin();
  const BenchOptions bench = bench_options(options);
  const auto benches = read_scenes(options, bench);
  const std::uint32_t repetitions = options.quick ? std::min(options.repetitions, 2u) : options.repetitions;
  for (const auto& scene : benches) scene->read_kernels();
  // Scenes take turns within every repetition.
  for (std::uint32_t i = 0; i < repetitions; ++i) {
    for (const auto& scene : benches) scene->repeat_start_up();
  }
  for (const auto& scene : benches) scene->open();
  if (!options.export_folder.empty()) export_all(options.export_folder, benches);
  for (std::uint32_t i = 0; i < repetitions; ++i) {
    for (const auto& scene : benches) scene->repeat();
  }
  BenchReport report{.device = benches.front()->device_name(),
                     .driver = benches.front()->driver_name(),
                     .processor = processor_name(),
                     .host_threads = thread_count(),
                     .repetitions = repetitions};
  for (const auto& scene : benches) report.scenes.push_back(scene->report());
  OutputWriter files;
  options.results.write_json(files, [&] { return bench_json(report); });
  if (options.results.wants_text()) print_text(bench_table(report));
  files.finish();
  if (report.passed()) return Ending::ok;
  log::error("Rays hit something else than in the reference; the rates are meaningless.");
  return Ending::failed;
}

}  // namespace

void add_bench_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("bench", "measure rays and samples per second, start-up and memory");
  const auto options = std::make_shared<BenchArguments>();
  command->add_option("SCENE", options->files, "scene files (default: three from the folder scenes)")
      ->file(kSceneEndings);
  command
      ->add_option("--repetitions", options->repetitions,
                   "number of measurements, of which the median is reported; 0: only check")
      ->check(in_range(0, 1000))
      ->capture_default_str();
  command->add_option("--time", options->time, "approximate time for samples in each repetition")
      ->type_name("TIME")
      ->capture_default_str();
  command->add_option("--rays", options->rays, "number of primary rays; 0: chosen to suit the device")
      ->check(in_range(0, 1 << 22))
      ->capture_default_str();
  command
      ->add_option("--part", options->parts,
                   "only this part: start, rays, samples, or kernels, what the driver's compiler says of the kernels "
                   "(only if named); may be repeated")
      ->type_name("PART")
      ->check(one_of({"start", "rays", "samples", "kernels"}))
      ->allow_extra_args(false);
  command
      ->add_option("--compiler", options->compiler,
                   "with --part kernels, the device whose driver compiles them (default: the one of --device)")
      ->type_name("DEVICE");
  command
      ->add_option("--export", options->export_folder,
                   "write scenes and rays for other programs into this folder (docs/benchmarks.md)")
      ->folder();
  options->sampling.add_to(*command);
  options->scene.add_to(*command);
  options->device.add_to(*command);
  command
      ->add_option("--loads", options->loads,
                   "how kernels read the scene's tables (default: chosen to suit device and scene)")
      ->type_name("BUFFER")
      ->check(one_of({"texel", "storage"}));
  command->add_flag("--quick", options->quick, "two short repetitions with few rays, to check that everything works");
  options->results.add_to(*command);
  command->callback([&action, options] { action = [options] { return run_bench(*options); }; });
}

}  // namespace etendue::cli
