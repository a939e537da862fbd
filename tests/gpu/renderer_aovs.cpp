/// What is rendered beside a picture: device against reference, and the same bytes however the samples are split.

#include <fmt/format.h>

#include "device_test.h"
#include "formats/read_scene.h"
#include "image/merge.h"
#include "reference/reference_renderer.h"
#include "reference_scenes.h"
#include "render/film_identity.h"
#include "render/render_job.h"
#include "render/shared_scene.h"
#include "validate/sample_comparison.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::quad;

class RendererAovs : public DeviceTest {};

// The Cornell box with its mirror and glass, a veil that lets half of the light pass, and a hole in the ceiling.
Scene veiled_room() {
  Scene scene = read_scene(SCENES_DIR "/cbox-sphere.xml",
                           {.overrides = {{"camera.width", "64"}, {"camera.height", "48"}}, .strict = true});
  TriangleMesh veil = quad({-0.4, 0.4, 0.6}, {0.5, 0, 0.1}, {0, 0.6, 0.1});
  veil.uv_sets = {{{0, 0}, {2, 0}, {2, 1}, {0, 1}}};
  Instance& instance = scene.add(std::move(veil));
  scene.materials.push_back({.adapter = MaskAdapter{{0.5}, instance.material}, .name = "mask"});
  instance.material = static_cast<std::uint32_t>(scene.materials.size() - 1);
  scene.sky.top = {0.5, 0.7, 1.0};
  scene.camera.filter.type = ReconstructionFilter::Type::mitchell;
  for (const AovTraits& row : all_aovs()) scene.aovs.push_back(row.aov);
  return scene;
}

void expect_agreement(Renderer& device, Renderer& reference, const Scene& scene, const std::string& what) {
  const SampleComparison c = compare_samples(device, reference, scene.camera.width, scene.camera.height, 12000);
  SCOPED_TRACE(fmt::format("{}: {:.0f} flips and {:.0f} off per million, median {:.2g}", what, c.flips_per_million(),
                           c.off_per_million(), c.median_error));
  EXPECT_EQ(c.non_finite, 0u);
  EXPECT_LE(c.flips_per_million(), 600);
  EXPECT_LE(c.off_per_million(), 400);
  EXPECT_LT(c.median_error, 5e-5);
}

TEST_F(RendererAovs, AgreeWithTheReference) {
  Scene scene = veiled_room();
  const RenderSettings settings{.seed = 3};
  const auto device = make_gpu_renderer(scene, settings, renderer_options());
  const auto reference = make_reference_renderer(scene, settings);
  for (const bool hidden : {false, true}) {
    scene.integrator.hide_emitters = hidden;
    for (const Aov aov : scene.aovs) {
      const View view = aov_view(view_of(scene), aov);
      device->set_view(view, settings);
      reference->set_view(view, settings);
      expect_agreement(*device, *reference, scene, fmt::format("{}, hidden {}", traits(aov).name, hidden));
    }
  }
}

// Whichever half a sample chose: there is no noise.
TEST_F(RendererAovs, AlbedoOfAMixtureIsThatOfBoth) {
  const glm::dvec3 first(0.2, 0.4, 0.9), second(0.8, 0.6, 0.1);
  Scene scene;
  scene.camera.width = scene.camera.height = 8;
  const std::uint32_t row = scene.add(quad({-9, -9, 1}, {18, 0, 0}, {0, 18, 0}), DiffuseBsdf{first}).material;
  scene.materials.push_back({.bsdf = DiffuseBsdf{second}});
  scene.materials.push_back({.adapter = BlendAdapter{0.3, row, row + 1}});
  scene.materials.push_back({.adapter = TwoSidedAdapter{row + 2, row + 2}});
  scene.instances[0].material = row + 3;
  const RenderSettings settings{.seed = 3};
  const View view = aov_view(view_of(scene), Aov::albedo);
  std::vector<SampleId> ids;
  for (std::uint32_t i = 0; i < 1000; ++i) ids.push_back({i % 64, i / 64});
  const glm::dvec3 expected = 0.7 * first + 0.3 * second;
  for (const bool reference : {false, true}) {
    const auto renderer =
        reference ? make_reference_renderer(scene, settings) : make_gpu_renderer(scene, settings, renderer_options());
    renderer->set_view(view, settings);
    for (const SampleRecord& sample : renderer->trace_samples(ids))
      EXPECT_LT(glm::distance(glm::dvec3(sample.radiance), expected), 1e-5) << reference;
  }
}

TEST_F(RendererAovs, PartsOfLightAgreeForEveryIntegrator) {
  Scene scene = veiled_room();
  const RenderSettings settings{.seed = 3};
  const auto device = make_gpu_renderer(scene, settings, renderer_options());
  const auto reference = make_reference_renderer(scene, settings);
  for (const Integrator::Type type : {Integrator::Type::direct, Integrator::Type::whitted}) {
    scene.integrator.type = type;
    scene.integrator.hide_background = true;
    for (const Aov aov : {Aov::direct, Aov::indirect}) {
      const View view = aov_view(view_of(scene), aov);
      device->set_view(view, settings);
      reference->set_view(view, settings);
      expect_agreement(*device, *reference, scene, fmt::format("{} of {}", traits(aov).name, static_cast<int>(type)));
    }
  }
}

TEST_F(RendererAovs, DirectAndIndirectLightAreAllLight) {
  const Scene scene = veiled_room();
  const RenderSettings settings{.seed = 3};
  const auto device = make_gpu_renderer(scene, settings, renderer_options());
  std::vector<SampleId> ids;
  for (std::uint32_t pixel = 0; pixel < 64 * 48; ++pixel) ids.push_back({pixel, pixel % 7});
  const auto values = [&](const View& view) {
    device->set_view(view, settings);
    return device->trace_samples(ids);
  };
  const View all = view_of(scene);
  const auto whole = values(all), direct = values(aov_view(all, Aov::direct));
  const auto indirect = values(aov_view(all, Aov::indirect));
  double parts = 0.0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const glm::vec3 sum = direct[i].radiance + indirect[i].radiance;
    const float tolerance = 1e-5f * (glm::length(whole[i].radiance) + 1e-6f);
    EXPECT_LT(glm::length(sum - whole[i].radiance), tolerance) << ids[i].pixel;
    parts += indirect[i].radiance.y > 0.0f && direct[i].radiance.y > 0.0f ? 1.0 : 0.0;
  }
  EXPECT_GT(parts, 100.0) << "most pixels have both";
}

FilmFile render_samples(const Scene& scene, const std::vector<SampleRange>& pieces, std::uint32_t pass_samples,
                        const GpuOptions& base) {
  GpuOptions options = base;
  options.fixed_samples = pass_samples;
  const FilmHeader identity = film_identity(scene, 5);
  const SharedScene shared(scene);
  std::vector<OpenRenderer> open = {[&] { return make_gpu_renderer(shared, RenderSettings{.seed = 5}, options); }};
  DeviceTeam team(std::move(open), aov_plan(scene, 5, identity));
  std::optional<RenderJob> job;
  for (const SampleRange& piece : pieces) {
    const FilmFile before = job ? job->state() : FilmFile{};
    const bool goes_on = job.has_value();
    job.emplace(identity, canonical(goes_on ? SampleRanges{before.samples.front(), {piece.begin, piece.end}}
                                            : SampleRanges{{piece.begin, piece.end}}));
    if (goes_on) job->resume(before, "before");
    job->advance(team, job->total(), [](std::uint64_t) { return true; });
  }
  return job->state();
}

TEST_F(RendererAovs, KeepTheirBytesHoweverSamplesAreSplit) {
  Scene scene = veiled_room();
  for (const std::uint32_t set_bits : {0u, 2u}) {
    if (set_bits > 0) scene.sampler = {Sampler::Type::sobol, 20, set_bits};
    const FilmFile whole = render_samples(scene, {{0, 5}}, 0, renderer_options());
    const FilmFile split = render_samples(scene, {{2, 5}, {0, 2}}, 1, renderer_options());
    EXPECT_EQ(whole.film.pixels(), split.film.pixels());
    ASSERT_EQ(whole.aovs.size(), all_aovs().size());
    for (std::size_t i = 0; i < whole.aovs.size(); ++i)
      EXPECT_EQ(whole.aovs[i].film.pixels(), split.aovs[i].film.pixels()) << traits(whole.aovs[i].aov).name;
    Scene alone = scene;
    alone.aovs.clear();
    EXPECT_EQ(render_samples(alone, {{0, 5}}, 0, renderer_options()).film.pixels(), whole.film.pixels());
  }
}

}  // namespace
}  // namespace etendue::test
