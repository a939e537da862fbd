/// Films of the scenes of scenes/, small, are the same bytes as when their hashes were written into
/// tests/data/film_hashes.json. Another driver may round differently and has hashes of its own there. Where one has
/// none, the films must be the same bytes when they are dispatched in other portions, and their hashes are printed.
/// With ETENDUE_UPDATE_HASHES=1 in the environment the hashes of this device and of the reference are written instead
/// of compared.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include <fmt/format.h>
#include <xxhash.h>
#include <nlohmann/json.hpp>

#include "device_test.h"
#include "formats/read_scene.h"
#include "reference/reference_renderer.h"

namespace etendue::test {
namespace {

constexpr std::uint32_t kWidth = 64, kHeight = 48, kSamples = 4, kSeed = 20;

struct Case {
  std::string name;
  Scene scene;
  FilmQuantity quantity = FilmQuantity::color;
};

void add_variants(std::vector<Case>& cases, const Scene& scene) {
  const auto vary = [&](const std::string& variant, const auto& change) {
    Case one{scene.name + ", " + variant, scene};
    change(one.scene);
    cases.push_back(std::move(one));
  };
  if (scene.name == "cbox-sphere" || scene.name == "thousand-lamps")
    vary("sobol", [](Scene& s) { s.sampler = {Sampler::Type::sobol, 4 * kSamples, 2}; });
  if (scene.name == "thousand-lamps")
    vary("by power", [](Scene& s) { s.integrator.light_sampler = Integrator::LightSampler::power; });
  if (scene.name != "cbox-sphere") return;
  vary("without nee", [](Scene& s) { s.integrator.nee = false; });
  vary("without mis", [](Scene& s) { s.integrator.mis = false; });
  vary("normals", [](Scene& s) { s.integrator.type = Integrator::Type::normals; });
  vary("tent", [](Scene& s) { s.camera.filter.type = ReconstructionFilter::Type::tent; });
  vary("mitchell", [](Scene& s) { s.camera.filter.type = ReconstructionFilter::Type::mitchell; });
  cases.push_back({scene.name + ", luminance", scene, FilmQuantity::luminance});
}

// Every scene of scenes/, those inside of test files included, and variants of some.
std::vector<Case> all_cases() {
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(SCENES_DIR)) {
    if (entry.path().extension() == ".xml") files.insert(entry.path());
  }
  std::vector<Case> cases;
  for (const auto& file : files) {
    const SceneFile content = read_scene_file(file.string(), {.overrides = {}, .strict = true});
    if (const auto* scene = std::get_if<Scene>(&content)) {
      cases.push_back({file.stem().string(), *scene});
      add_variants(cases, *scene);
    } else if (const auto* test = std::get_if<TTest>(&content)) {
      for (std::size_t i = 0; i < test->scenes.size(); ++i)
        cases.push_back({fmt::format("{}, scene {}", file.stem().string(), i + 1), test->scenes[i]});
    }
  }
  for (Case& one : cases) {
    one.scene.camera.width = kWidth;
    one.scene.camera.height = kHeight;
  }
  return cases;
}

using Hashes = std::map<std::string, std::string>;
using MakeRenderer = std::function<std::unique_ptr<Renderer>(const Scene&, const RenderSettings&)>;

// Of the sums alone: nothing that a file would say about them.
std::string film_hash(const Case& one, const MakeRenderer& make) {
  const auto renderer = make(one.scene, {.seed = kSeed, .quantity = one.quantity});
  Film film(kWidth, kHeight, film_exponent(one.scene));
  std::vector<RejectedSample> rejected;
  renderer->render({0, kSamples}, film, {}, rejected);
  EXPECT_TRUE(rejected.empty()) << one.name;
  std::uint64_t lit = 0;
  for (const FilmPixel& pixel : film.pixels()) {
    EXPECT_EQ(pixel.count, kSamples) << one.name;
    lit += pixel.sum != decltype(pixel.sum){};
  }
  EXPECT_GT(lit, kWidth * kHeight / 20) << one.name << " is all but black";
  return fmt::format("{:016x}", XXH3_64bits(film.pixels().data(), film.pixels().size() * sizeof(FilmPixel)));
}

nlohmann::json read_list() {
  std::ifstream file(HASHES_FILE);
  return nlohmann::json::parse(file);
}

Hashes film_hashes(const MakeRenderer& make) {
  Hashes out;
  for (const Case& one : all_cases()) out[one.name] = film_hash(one, make);
  return out;
}

// `make_otherwise` makes renderers that dispatch the same samples in other portions.
void compare_with_list(const std::string& device, const MakeRenderer& make, const MakeRenderer& make_otherwise) {
  const Hashes now = film_hashes(make);
  nlohmann::json list = read_list();
  if (std::getenv("ETENDUE_UPDATE_HASHES") != nullptr) {
    list[device] = now;
    std::ofstream(HASHES_FILE) << list.dump(2) << '\n';
    return;
  }
  if (!list.contains(device)) {
    fmt::print("{} knows nothing of this device; its films have the hashes\n{}\n", HASHES_FILE,
               nlohmann::json{{device, now}}.dump(2));
    EXPECT_EQ(film_hashes(make_otherwise), now) << "on " << device << ", dispatched in other portions";
    return;
  }
  EXPECT_EQ(list[device].get<Hashes>(), now)
      << "on " << device
      << ". Where the arithmetic was meant to change, say so in the commit and write the list anew with "
      << "ETENDUE_UPDATE_HASHES=1; docs/validation.md, \"Film hashes\".";
}

class FilmHashes : public DeviceTest {};

TEST_F(FilmHashes, OnTheDevice) {
  std::string name;
  {
    const auto any = make_gpu_renderer(Scene{}, {}, renderer_options());
    name = fmt::format("{}, {}, {} children a node", any->device_name(), any->driver_name(), gpu::kBvhWidth);
  }
  const auto make = [](const GpuOptions& options) {
    return [options](const Scene& scene, const RenderSettings& settings) {
      return make_gpu_renderer(scene, settings, options);
    };
  };
  GpuOptions otherwise = renderer_options();
  otherwise.fixed_samples = 1;
  otherwise.fixed_groups = 7;
  compare_with_list(name, make(renderer_options()), make(otherwise));
}

// Double precision without fused multiply-adds gives the same films on every machine of a kind.
TEST(FilmHashesReference, OnThisKindOfMachine) {
#if defined(__x86_64__)
  const std::string name = "reference, x86-64";
#elif defined(__aarch64__)
  const std::string name = "reference, AArch64";
#else
  const std::string name = "reference, another machine";
#endif
  const auto make = [](const Scene& scene, const RenderSettings& settings) {
    return make_reference_renderer(scene, settings);
  };
  compare_with_list(name, make, make);
}

}  // namespace
}  // namespace etendue::test
