/// L1 of the equality contract: on one device, the split of the work never changes a bit of the film.

#include "device_test.h"
#include "formats/read_scene.h"
#include "reference_scenes.h"
#include "scene/limits.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::diffuse;

class RendererEquality : public DeviceTest {};

// The Cornell box with everything in it (mirror, glass, lamp, roulette) at a size that is no multiple of the tile.
Scene cornell(std::uint32_t width, std::uint32_t height) {
  return read_scene(SCENES_DIR "/cbox-sphere.xml",
                    {.overrides = {{"camera.width", std::to_string(width)}, {"camera.height", std::to_string(height)}},
                     .strict = true});
}

Film render(const Scene& scene, const std::vector<SampleRange>& ranges, const GpuOptions& options,
            RenderSettings settings = {.seed = 3}) {
  const auto renderer = make_gpu_renderer(scene, settings, options);
  Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
  for (const SampleRange range : ranges) {
    std::vector<RejectedSample> rejected;
    EXPECT_EQ(renderer->render(range, film, {}, rejected), range.end);
    EXPECT_TRUE(rejected.empty());
  }
  return film;
}

void expect_equal(const Film& a, const Film& b, const std::string& what) {
  ASSERT_EQ(a.pixels().size(), b.pixels().size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) different += !(a.pixels()[i] == b.pixels()[i]);
  EXPECT_EQ(different, 0u) << "pixels that differ: " << what;
}

TEST_F(RendererEquality, PassSizesAndDispatchSizes) {
  const Scene scene = cornell(45, 29);
  const Film whole = render(scene, {{0, 13}}, renderer_options());
  for (const FilmPixel& p : whole.pixels()) ASSERT_EQ(p.count, 13u);
  for (const auto& [samples, groups] : {std::pair{1u, 1u}, {1u, 0u}, {2u, 7u}, {5u, 3u}, {64u, 1000u}, {0u, 2u}}) {
    GpuOptions options = renderer_options();
    options.fixed_samples = samples;
    options.fixed_groups = groups;
    expect_equal(render(scene, {{0, 13}}, options), whole,
                 std::to_string(samples) + " samples, " + std::to_string(groups) + " groups a dispatch");
  }
}

// Inside a ball of checkerboards in checkerboards. When a kernel has taken more iterations of all its loops than a
// driver allows, a lookup ends early; how many it takes depends on the size of a dispatch.
TEST_F(RendererEquality, LookupsInNestedTexturesCount) {
  Scene scene;
  for (std::uint32_t depth = 0; depth < kMaxNestedTextures; ++depth) {
    CheckerboardTexture board{glm::dvec3(1.0, 0.98, 0.99), glm::dvec3(0.97, 1.0, 0.98)};
    if (depth > 0) board.texture0 = board.texture1 = depth - 1;
    Texture& texture = scene.textures.emplace_back(Texture{.source = board});
    texture.uv_transform[0][0] = texture.uv_transform[1][1] = 1.0 + depth;
  }
  DiffuseBsdf walls = diffuse(1.0);
  walls.albedo.texture = kMaxNestedTextures - 1;
  add(scene, Sphere{}, walls, glm::dvec3(0.01)).flip_normals = true;
  scene.emitters[0].radiance.texture = kMaxNestedTextures - 1;
  scene.camera = reference::test::pixel_camera({0, 0, 0}, {1, 0, 0}, 60.0);
  scene.camera.width = scene.camera.height = 64;
  scene.integrator.max_depth = 6;
  GpuOptions options = renderer_options();
  options.fixed_groups = 1;
  options.fixed_samples = 64;
  const Film few = render(scene, {{0, 700}}, options);
  options.fixed_samples = 700;
  expect_equal(render(scene, {{0, 700}}, options), few, "all samples of a group in one dispatch");
}

// A slot's next path would have a number beyond 2^32 there.
TEST_F(RendererEquality, TheLastSamplesThereAre) {
  constexpr std::uint32_t kEnd = ~0u;
  const Scene scene = cornell(4, 3);
  const Film whole = render(scene, {{kEnd - 3000, kEnd}}, renderer_options());
  for (const FilmPixel& p : whole.pixels()) ASSERT_EQ(p.count, 3000u);
  expect_equal(render(scene, {{kEnd - 3000, kEnd - 7}, {kEnd - 7, kEnd}}, renderer_options()), whole, "two ranges");
}

TEST_F(RendererEquality, TexelAndStorageLoads) {
  for (const Scene& scene : {cornell(37, 21), read_scene(SCENES_DIR "/bubble.xml", {})}) {
    Scene small = scene;
    small.camera.width = 37;
    small.camera.height = 21;
    GpuOptions options = renderer_options();
    options.loads = TableLoads::texel_buffer;
    const Film texels = render(small, {{0, 3}}, options);
    options.loads = TableLoads::storage_buffer;
    expect_equal(render(small, {{0, 3}}, options), texels, "storage buffers");
  }
}

TEST_F(RendererEquality, SampleRangesAddUp) {
  const Scene scene = cornell(33, 17);
  const Film whole = render(scene, {{0, 24}}, renderer_options());
  expect_equal(render(scene, {{0, 1}, {1, 8}, {8, 24}}, renderer_options()), whole, "three ranges, one renderer");
  expect_equal(render(scene, {{16, 24}, {0, 16}}, renderer_options()), whole, "the later range first");
  Film merged = render(scene, {{5, 24}}, renderer_options());
  merged.merge(render(scene, {{0, 5}}, renderer_options()));
  expect_equal(merged, whole, "two renderers, merged films");
}

TEST_F(RendererEquality, SmallFilmsDealSamplesToManySlots) {
  // A 1 × 1 film spreads its samples over all lanes; how many a range has decides the number of layers.
  const Scene scene = cornell(1, 1);
  const Film whole = render(scene, {{0, 5000}}, renderer_options());
  ASSERT_EQ(whole.pixels()[0].count, 5000u);
  expect_equal(render(scene, {{0, 17}, {17, 18}, {18, 4114}, {4114, 5000}}, renderer_options()), whole,
               "ranges with other layers");
  GpuOptions options = renderer_options();
  options.fixed_samples = 3;
  options.fixed_groups = 11;
  expect_equal(render(scene, {{0, 5000}}, options), whole, "other passes");
  const Scene strip = cornell(9, 2);
  expect_equal(render(strip, {{0, 100}, {100, 301}}, renderer_options()), render(strip, {{0, 301}}, renderer_options()),
               "a 9 × 2 film");
}

// The Cornell box with sets of 8 Sobol points.
Scene sobol_cornell(std::uint32_t width, std::uint32_t height) {
  Scene scene = cornell(width, height);
  scene.sampler = {Sampler::Type::sobol, 64, 3};
  return scene;
}

TEST_F(RendererEquality, SobolSetsAreWholeHoweverTheWorkIsSplit) {
  const Scene scene = sobol_cornell(29, 13);
  const Film whole = render(scene, {{0, 7}}, renderer_options());
  for (const FilmPixel& p : whole.pixels()) ASSERT_EQ(p.count, 7u);
  for (const auto& [samples, groups] : {std::pair{1u, 1u}, {2u, 7u}, {5u, 3u}, {64u, 1000u}}) {
    GpuOptions options = renderer_options();
    options.fixed_samples = samples;
    options.fixed_groups = groups;
    expect_equal(render(scene, {{0, 7}}, options), whole,
                 std::to_string(samples) + " sets, " + std::to_string(groups) + " groups a dispatch");
  }
  expect_equal(render(scene, {{4, 7}, {0, 1}, {1, 4}}, renderer_options()), whole, "three ranges");
  const Scene point = sobol_cornell(1, 1);
  const Film deep = render(point, {{0, 5000}}, renderer_options());
  ASSERT_EQ(deep.pixels()[0].count, 5000u);
  expect_equal(render(point, {{0, 17}, {17, 4114}, {4114, 5000}}, renderer_options()), deep, "slots of one pixel");
}

TEST_F(RendererEquality, ASobolSampleIsTheMeanOverItsSet) {
  const Scene scene = sobol_cornell(12, 9);
  if (!is_lavapipe()) return;  // two kernels: another driver may round them differently
  const Film film = render(scene, {{2, 5}}, renderer_options());
  const auto renderer = make_gpu_renderer(scene, {.seed = 3}, renderer_options());
  std::vector<SampleId> ids;
  for (std::uint32_t pixel = 0; pixel < 108; ++pixel) {
    for (std::uint32_t path = 16; path < 40; ++path) ids.push_back({pixel, path});
  }
  const auto records = renderer->trace_samples(ids);
  Film sum(12, 9, film_exponent(scene));
  for (std::size_t first = 0; first < ids.size(); first += 8) {
    glm::vec3 mean(0.0f);
    for (std::size_t i = first; i < first + 8; ++i) mean += records[i].radiance;
    sum.pixels()[ids[first].pixel].add(mean / 8.0f, sum.exponent());
  }
  expect_equal(sum, film, "set by set");
}

TEST_F(RendererEquality, StoppingAndGoingOn) {
  const Scene scene = cornell(31, 11);
  const Film whole = render(scene, {{2, 40}}, renderer_options());
  GpuOptions options = renderer_options();
  options.fixed_samples = 1;
  const auto renderer = make_gpu_renderer(scene, {.seed = 3}, options);
  Film film(31, 11, film_exponent(scene));
  std::vector<RejectedSample> rejected;
  std::uint32_t done = 2;
  int stops = 0;
  while (done < 40) {
    int passes = 0;
    const std::uint32_t reached = renderer->render(
        {done, 40}, film, [&](std::uint64_t, std::uint64_t) { return ++passes < 2; }, rejected);
    ASSERT_GT(reached, done);
    done = reached;
    ++stops;
  }
  EXPECT_GT(stops, 1) << "the renderer did not stop when asked";
  expect_equal(film, whole, "stopped and resumed");
}

TEST_F(RendererEquality, FilmIsTheSumOfItsSamples) {
  const Scene scene = cornell(21, 10);
  if (!is_lavapipe()) return;  // two kernels: another driver may round them differently
  const Film film = render(scene, {{4, 9}}, renderer_options());
  const auto renderer = make_gpu_renderer(scene, {.seed = 3}, renderer_options());
  std::vector<SampleId> ids;
  for (std::uint32_t pixel = 0; pixel < 210; ++pixel) {
    for (std::uint32_t s = 4; s < 9; ++s) ids.push_back({pixel, s});
  }
  Film sum(21, 10, film_exponent(scene));
  const auto records = renderer->trace_samples(ids);
  for (std::size_t i = 0; i < ids.size(); ++i) sum.pixels()[ids[i].pixel].add(records[i].radiance, sum.exponent());
  expect_equal(sum, film, "samples one by one");
}

TEST_F(RendererEquality, LargeFilmsAreRenderedInBands) {
  // 1032 × 1032 pixels take more than the 128 MiB that one storage buffer holds on lavapipe.
  Scene scene;
  scene.camera.width = scene.camera.height = 1032;
  scene.integrator.type = Integrator::Type::normals;
  scene.camera.world_from_camera[3] = glm::dvec4(0, 0, -4, 1);
  add(scene, Sphere{{0, 0, 0}, 1.0}, diffuse(0.5));
  const Film film = render(scene, {{0, 1}}, renderer_options());
  GpuOptions options = renderer_options();
  options.fixed_groups = 5000;
  expect_equal(render(scene, {{0, 1}}, options), film, "another dispatch size");
  if (!is_lavapipe()) return;
  const auto renderer = make_gpu_renderer(scene, {.seed = 3}, renderer_options());
  std::vector<SampleId> ids;
  for (std::uint32_t pixel = 0; pixel < 1032 * 1032; pixel += 97) ids.push_back({pixel, 0});
  for (std::uint32_t x = 0; x < 1032; ++x) ids.push_back({1031 * 1032 + x, 0});
  const auto records = renderer->trace_samples(ids);
  std::size_t different = 0, lit = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    FilmPixel expected;
    expected.add(records[i].radiance, film.exponent());
    different += !(film.pixels()[ids[i].pixel] == expected);
    lit += records[i].radiance != glm::vec3(0.0f);
  }
  EXPECT_EQ(different, 0u);
  EXPECT_GT(lit, ids.size() / 10);
}

TEST_F(RendererEquality, SeedsAndQuantitiesDiffer) {
  const Scene scene = cornell(16, 16);
  const Film a = render(scene, {{0, 4}}, renderer_options(), {.seed = 1});
  const Film b = render(scene, {{0, 4}}, renderer_options(), {.seed = 2});
  std::size_t equal = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) equal += a.pixels()[i] == b.pixels()[i];
  EXPECT_LT(equal, a.pixels().size() / 2);  // only pixels that see the lamp or nothing in every sample
  const Film luminance = render(scene, {{0, 4}}, renderer_options(), {.seed = 1, .quantity = FilmQuantity::luminance});
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const glm::dvec3 rgb = a.mean(i), y = luminance.mean(i);
    EXPECT_EQ(y.r, y.b);
    const double expected = glm::dot(rgb, glm::dvec3(0.212671, 0.715160, 0.072169));
    EXPECT_NEAR(y.g, expected, 2e-6 * (expected + 1e-3));
  }
}

}  // namespace
}  // namespace etendue::test
