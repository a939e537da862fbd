#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include <fmt/core.h>
#include "cli/command.h"
#include "cli/path_words.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "cli/units.h"
#include "core/json.h"
#include "core/printable.h"

namespace etendue::cli {
namespace {

struct ExplainArguments {
  std::string scene_file;
  SceneOptions scene;
  DeviceOption device;
  SampleOptions sampling;
  std::string pixel;  ///< "X,Y"; empty: the middle
  std::uint32_t sample = 0;
  std::uint64_t lights = 0;  ///< number of paths whose lights are counted; 0: one path is explained
  ResultOptions results;
};

/// How often next-event estimation chose a light, and how often it was unoccluded.
struct LightTally {
  std::uint64_t chosen = 0, reached = 0;
};

struct Tally {
  std::uint64_t paths = 0;
  std::uint64_t light_samples = 0;
  std::map<std::uint32_t, LightTally> lights;  ///< by instance
};

/// "X,Y" to a pixel number. Throws Error(usage).
std::uint32_t parse_pixel(const std::string& text, const Camera& camera) {
  if (text.empty()) return camera.height / 2 * camera.width + camera.width / 2;
  unsigned x = 0, y = 0;
  int used = 0;
  if (std::sscanf(text.c_str(), "%9u,%9u%n", &x, &y, &used) != 2 || static_cast<std::size_t>(used) != text.size() ||
      x >= camera.width || y >= camera.height) {
    throw Error(ErrorKind::usage,
                fmt::format("'--pixel {}' names no pixel of {}x{}; write X,Y with 0,0 at the top left.", text,
                            camera.width, camera.height));
  }
  return y * camera.width + x;
}

void tell_path(Renderer& renderer, const Scene& scene, SampleId id, const ExplainArguments& options) {
  const std::vector<PathVertex> path = renderer.trace_path(id);
  const std::uint32_t x = id.pixel % scene.camera.width, y = id.pixel / scene.camera.width;
  OutputWriter files;
  options.results.write_json(files, [&] {
    auto vertices = Json::array();
    for (const PathVertex& vertex : path) vertices.push_back(to_json(vertex));
    return Json{{"scene", options.scene_file},
                {"device", renderer.device_name()},
                {"seed", options.sampling.seed},
                {"x", x},
                {"y", y},
                {"sample", id.sample},
                {"vertices", vertices}};
  });
  files.finish();
  if (!options.results.wants_text()) return;
  print_result("{} on {}, seed {}: pixel ({}, {}), sample {}\n",
               text::printable(options.scene_file, text::kLongestLine), renderer.device_name(), options.sampling.seed,
               x, y, id.sample);
  print_result("{:>7}  {:<16} {:<16} {:<8} {:<15} {:<8}  radiance gathered so far\n", "segment", "meets", "light",
               "reached", "lobe", "survives");
  for (std::size_t i = 0; i < path.size(); ++i) {
    const PathVertex& v = path[i];
    const VertexWords words = words_of(v);
    print_result("{:>7}  {:<16} {:<16} {:<8} {:<15} {:<8}  {:.5g} {:.5g} {:.5g}\n", i + 1, words.meets, words.light,
                 words.reached, words.lobe, words.survives, v.radiance.x, v.radiance.y, v.radiance.z);
  }
}

/// Distributes paths evenly over the picture by multiples of the golden ratio, so that pictures of few pixels are
/// covered evenly, too.
Tally count_lights(Renderer& renderer, const Scene& scene, std::uint64_t paths) {
  constexpr double kGolden = 0.6180339887498949;
  const double pixels = static_cast<double>(std::uint64_t{scene.camera.width} * scene.camera.height);
  Tally tally{.paths = paths, .light_samples = 0, .lights = {}};
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (scene.instances[i].emitter) tally.lights[i] = {};
  }
  for (std::uint64_t i = 0; i < paths; ++i) {
    const double fraction = std::fmod(0.5 + static_cast<double>(i) * kGolden, 1.0);
    const SampleId id{static_cast<std::uint32_t>(fraction * pixels), static_cast<std::uint32_t>(i)};
    for (const PathVertex& vertex : renderer.trace_path(id)) {
      if (vertex.light_instance == PathVertex::kNone) continue;
      ++tally.light_samples;
      LightTally& light = tally.lights[vertex.light_instance];
      ++light.chosen;
      light.reached += vertex.light_contributed == 1 ? 1 : 0;
    }
  }
  return tally;
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

void tell_lights(Renderer& renderer, const Scene& scene, const ExplainArguments& options) {
  const Tally tally = count_lights(renderer, scene, options.lights);
  OutputWriter files;
  options.results.write_json(files, [&] {
    auto lights = Json::array();
    for (const auto& [instance, light] : tally.lights) {
      lights.push_back({{"instance", light_json(instance)},
                        {"chosen", light.chosen},
                        {"share", share(light.chosen, tally.light_samples)},
                        {"reached", light.reached}});
    }
    return Json{{"scene", options.scene_file}, {"device", renderer.device_name()},    {"seed", options.sampling.seed},
                {"paths", tally.paths},        {"lightSamples", tally.light_samples}, {"lights", lights}};
  });
  files.finish();
  if (!options.results.wants_text()) return;
  print_result("{} on {}, seed {}: {} light samples of {} paths\n",
               text::printable(options.scene_file, text::kLongestLine), renderer.device_name(), options.sampling.seed,
               tally.light_samples, tally.paths);
  print_result("{:<13} {:>10} {:>8} {:>10}\n", "light", "chosen", "share", "unhidden");
  for (const auto& [instance, light] : tally.lights) {
    const std::string name = instance == PathVertex::kEnvironment  ? "sky"
                             : instance == PathVertex::kDeltaLight ? "points"
                                                                   : fmt::format("instance {:<4}", instance);
    print_result("{:<13} {:>10} {:>6.2f} % {:>8.2f} %\n", name, light.chosen,
                 100.0 * share(light.chosen, tally.light_samples), 100.0 * share(light.reached, light.chosen));
  }
}

Ending explain(const ExplainArguments& options) {
  options.results.begin();
  if (options.sampling.spp > 0 && options.sample >= options.sampling.spp)
    throw Error(ErrorKind::usage,
                fmt::format("'--sample {}' is not one of the {} samples given by '--spp'; they are numbered from 0.",
                            options.sample, options.sampling.spp));
  Scene scene = read_scene(options.scene_file, options.scene.read_options());
  options.sampling.set_size(scene);
  const SampleId id{parse_pixel(options.pixel, scene.camera), options.sample};
  const auto renderer = options.device.factory()(scene, RenderSettings{.seed = options.sampling.seed});
  if (options.lights > 0) {
    tell_lights(*renderer, scene, options);
  } else {
    tell_path(*renderer, scene, id, options);
  }
  return Ending::ok;
}

}  // namespace

void add_explain_command(Command& app, Action& action) {
  auto* command = app.add_subcommand(
      "explain", "show the path of one sample, vertex by vertex, or count which lights the samples of a scene choose");
  const auto options = std::make_shared<ExplainArguments>();
  options->device.selector = "reference";
  command->add_option("SCENE", options->scene_file, "scene file")->required()->file(kSceneEndings);
  command->add_option("--pixel", options->pixel, "pixel of the sample; 0,0 is at the top left (default: the middle)")
      ->type_name("X,Y");
  command->add_option("--sample", options->sample, "index of the sample")->capture_default_str();
  command
      ->add_option("--lights", options->lights,
                   "trace this many paths, spread evenly over the picture, and count the lights they choose")
      ->check(in_range(1u, 100'000'000u));
  options->sampling.add_to(*command);
  options->scene.add_to(*command);
  options->device.add_to(*command);
  options->results.add_to(*command);
  command->callback([&action, options] { action = [options] { return explain(*options); }; });
}

}  // namespace etendue::cli
