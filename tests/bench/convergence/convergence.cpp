/// Time until a picture is right: renders a scene with each way of finding light and each sampler, measures the error
/// against a long reference, and says how long each takes to a given relative error. A table in Markdown on stdout.

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "core/command_line.h"
#include "core/errors.h"
#include "core/terminal.h"
#include "formats/read_scene.h"
#include "gpu/gpu_renderer.h"
#include "image/image.h"

using namespace etendue;

namespace {

struct Options {
  std::vector<std::string> scenes;
  std::uint32_t width = 96, height = 72;
  std::uint32_t paths = 256;             ///< per pixel, of each way
  std::uint32_t reference_paths = 8192;  ///< per pixel
  std::uint32_t set_size = 64;
  double error = 0.01;
};

/// One way of rendering and what it took.
struct Way {
  std::string name;
  Scene scene;
  std::unique_ptr<Renderer> renderer;
  Film film;
  std::uint32_t sets = 0;
  double seconds = 0;  ///< of all threads together

  std::uint64_t paths() const { return std::uint64_t{sets} * scene.sampler.set_size(); }
};

/// Seconds all threads of this process have computed: another process on the machine does not count.
double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

void render_more(Way& way, std::uint64_t paths) {
  const auto end = static_cast<std::uint32_t>(way.scene.sampler.sets_of(paths));
  if (end <= way.sets) return;
  const double start = cpu_seconds();
  std::vector<RejectedSample> rejected;
  way.renderer->render({way.sets, end}, way.film, {}, rejected);
  way.seconds += cpu_seconds() - start;
  way.sets = end;
}

Way make_way(const std::string& name, Scene scene, std::uint32_t seed) {
  Way way{.name = name, .scene = std::move(scene), .renderer = nullptr, .film = {}};
  way.renderer = make_gpu_renderer(way.scene, {.seed = seed}, {});
  way.film = Film(way.scene.camera.width, way.scene.camera.height, film_exponent(way.scene));
  // The driver compiles at the first dispatch, which is no part of convergence.
  Film scratch = way.film;
  std::vector<RejectedSample> rejected;
  way.renderer->render({0, 1}, scratch, {}, rejected);
  return way;
}

std::vector<Way> make_ways(const Scene& scene, std::uint32_t set_size) {
  std::vector<Way> ways;
  for (const bool sobol : {false, true}) {
    for (const char* strategy : {"naive", "NEE", "MIS"}) {
      Scene variant = scene;
      variant.integrator.nee = strategy != std::string("naive");
      variant.integrator.mis = strategy == std::string("MIS");
      variant.sampler = {};
      if (sobol) {
        variant.sampler.type = Sampler::Type::sobol;
        while (variant.sampler.set_size() < set_size) ++variant.sampler.set_bits;
      }
      ways.push_back(make_way(fmt::format("{}, {}", strategy, sobol ? "sobol" : "independent"), std::move(variant), 7));
    }
  }
  if (uses_light_tree(scene)) {
    Scene by_power = ways.back().scene;
    by_power.integrator.light_sampler = Integrator::LightSampler::power;
    ways.push_back(make_way("MIS, sobol, lights by power", std::move(by_power), 7));
  }
  return ways;
}

double luminance(const glm::vec3& rgb) {
  return 0.212671 * static_cast<double>(rgb.r) + 0.715160 * static_cast<double>(rgb.g) +
         0.072169 * static_cast<double>(rgb.b);
}

/// Root mean square of the difference in luminance over the mean luminance, without the 1 % of pixels that differ most:
/// a few bright specks (caustics) would decide alone.
double relative_error(const Film& film, const Film& reference) {
  std::vector<double> squares;
  double mean = 0.0;
  for (std::size_t i = 0; i < film.pixels().size(); ++i) {
    const double difference = luminance(film.mean(i)) - luminance(reference.mean(i));
    squares.push_back(difference * difference);
    mean += luminance(reference.mean(i));
  }
  mean /= static_cast<double>(squares.size());
  std::sort(squares.begin(), squares.end());
  squares.resize(squares.size() - squares.size() / 100);
  double sum = 0.0;
  for (const double square : squares) sum += square;
  return std::sqrt(sum / static_cast<double>(squares.size())) / mean;
}

void measure(const std::string& file, const Options& options) {
  Scene scene = read_scene(file, {});
  scene.camera.width = options.width;
  scene.camera.height = options.height;
  Scene longest = scene;
  longest.sampler = {.type = Sampler::Type::sobol, .set_bits = 6};
  Way reference = make_way("reference", longest, 1);
  render_more(reference, options.reference_paths);
  std::vector<Way> ways = make_ways(scene, options.set_size);
  // In turns, so that a machine that grows slower does so for all.
  for (std::uint64_t paths = options.set_size; paths <= options.paths; paths *= 2) {
    for (Way& way : ways) render_more(way, paths);
  }
  fmt::print("\n{}, {}x{}, reference of {} paths per pixel\n\n", scene.name, options.width, options.height,
             reference.paths());
  fmt::print(
      "| configuration | paths per pixel | CPU seconds | Msamples per CPU second | relative error | CPU seconds to "
      "{:g} % |\n",
      100.0 * options.error);
  fmt::print("|---|---|---|---|---|---|\n");
  const double pixels = static_cast<double>(options.width) * options.height;
  for (const Way& way : ways) {
    const double error = relative_error(way.film, reference.film);
    // Sets of paths are independent: beyond one set the error falls with the root of their number.
    const double factor = error / options.error;
    fmt::print("| {} | {} | {:.2f} | {:.3f} | {:.2f} % | {:.1f} |\n", way.name, way.paths(), way.seconds,
               1e-6 * pixels * static_cast<double>(way.paths()) / way.seconds, 100.0 * error,
               way.seconds * factor * factor);
  }
}

int run(int argc, char** argv) {
  Command app("Time to a given relative error, for each way of finding light and each sampler.", "convergence");
  Options options;
  app.add_option("SCENE", options.scenes, "scene files")->required();
  app.add_option("--width", options.width)->capture_default_str();
  app.add_option("--height", options.height)->capture_default_str();
  app.add_option("--paths", options.paths, "paths per pixel of each way")->capture_default_str();
  app.add_option("--reference", options.reference_paths, "paths per pixel of the reference")->capture_default_str();
  app.add_option("--set-size", options.set_size, "of the sobol sampler")->capture_default_str();
  app.add_option("--error", options.error, "relative error to reach")->capture_default_str();
  if (const std::optional<bool> end = app.parse(argc, argv)) return *end ? 0 : 2;
  for (const std::string& scene : options.scenes) measure(scene, options);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const TerminalLog messages;
  try {
    return static_cast<int>(run(argc, argv));
  } catch (const Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
