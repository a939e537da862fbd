/// The renderer's promises: a pure function of (scene, seed, sample range), whatever the threads, passes and splits.

#include <atomic>
#include <limits>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "reference_scenes.h"

namespace etendue::reference::test {
namespace {

/// Lamps, glass, mirror, every decision there is.
Scene decisions_scene() {
  Scene scene;
  scene.camera.width = 13, scene.camera.height = 7, scene.camera.fov = 70;
  scene.camera.world_from_camera = look_at({0, 0, -0.95}, {0, -0.1, 0.2}, {0, 1, 0});
  scene.camera.filter.type = ReconstructionFilter::Type::mitchell;
  scene.integrator.max_depth = 9;
  scene.integrator.rr_depth = 3;
  TriangleMesh room = box(Vec3(-1.0), Vec3(1.0), true);
  room.triangles.resize(8);  // open: some paths leave
  add(scene, room, DiffuseBsdf{.albedo = {0.7, 0.5, 0.4}});
  add(scene, quad({-0.4, 0.9, -0.4}, {0.8, 0, 0}, {0, 0, 0.8}), diffuse(0.0), Vec3(4, 5, 6));
  add(scene, Sphere{{0.6, -0.5, 0.5}, 0.35}, DielectricBsdf{});
  add(scene, Sphere{{-0.5, -0.5, 0.4}, 0.35}, MirrorBsdf{});
  add(scene, Sphere{{0.0, 0.2, 0.6}, 0.1}, diffuse(0.5), Vec3(2, 3, 4));
  scene.sky.top = {0.1, 0.2, 0.4};
  return scene;
}

std::vector<SampleId> all_ids(const Scene& scene, SampleRange range) {
  std::vector<SampleId> ids;
  for (std::uint32_t p = 0; p < scene.camera.width * scene.camera.height; ++p)
    for (std::uint32_t s = range.begin; s < range.end; ++s) ids.push_back({p, s});
  return ids;
}

Film render(const Scene& scene, SampleRange range, const RenderSettings& settings = {}) {
  Film film(scene.camera.width, scene.camera.height, kExponent);
  std::vector<RejectedSample> rejected;
  EXPECT_EQ(make_reference_renderer(scene, settings)->render(range, film, {}, rejected), range.end);
  return film;
}

struct ThreadCount {
  explicit ThreadCount(unsigned count) { set_thread_count(count); }
  ~ThreadCount() { set_thread_count(0); }
};

TEST(ReferenceRenderer, RendersWhatItTraces) {
  const Scene scene = decisions_scene();
  for (const FilmQuantity quantity : {FilmQuantity::color, FilmQuantity::luminance}) {
    const RenderSettings settings{.seed = 5, .quantity = quantity};
    const auto ids = all_ids(scene, {3, 40});
    const auto records = make_reference_renderer(scene, settings)->trace_samples(ids);
    Film expected(scene.camera.width, scene.camera.height, kExponent);
    for (std::size_t i = 0; i < ids.size(); ++i) expected.pixels()[ids[i].pixel].add(records[i].radiance, kExponent);
    EXPECT_TRUE(render(scene, {3, 40}, settings).pixels() == expected.pixels());
  }
}

TEST(ReferenceRenderer, ThreadsAndSplitsChangeNoBit) {
  const Scene scene = decisions_scene();
  const Film whole = render(scene, {0, 300});
  for (const unsigned threads : {1u, 2u, 7u}) {
    const ThreadCount guard(threads);
    EXPECT_TRUE(render(scene, {0, 300}).pixels() == whole.pixels()) << threads;
  }
  Film parts = render(scene, {100, 300});
  parts.merge(render(scene, {0, 99}));
  parts.merge(render(scene, {99, 100}));
  EXPECT_TRUE(parts.pixels() == whole.pixels());
}

TEST(ReferenceRenderer, SeedsAndSamplesDiffer) {
  const Scene scene = decisions_scene();
  EXPECT_FALSE(render(scene, {0, 8}, {.seed = 1}).pixels() == render(scene, {0, 8}, {.seed = 2}).pixels());
  EXPECT_FALSE(render(scene, {0, 8}).pixels() == render(scene, {8, 16}).pixels());
}

TEST(ReferenceRenderer, OnePixelKeepsAllThreadsBusy) {
  Scene scene = decisions_scene();
  scene.camera.width = scene.camera.height = 1;
  scene.camera.filter.type = ReconstructionFilter::Type::box;
  const Film film = render(scene, {0, 100000});
  EXPECT_EQ(film.pixels()[0].count, 100000u);
  const ThreadCount guard(1);
  EXPECT_TRUE(render(scene, {0, 100000}).pixels() == film.pixels());
}

/// docs/conventions.md, "Path signature", folded again from the record of a path.
std::uint32_t fold(const std::vector<PathVertex>& vertices) {
  std::uint32_t h = 0x811c9dc5u;
  const auto word = [&](std::uint32_t w) { h = (h ^ w) * 0x01000193u; };
  for (const PathVertex& v : vertices) {
    if (v.instance == PathVertex::kNone) {
      word(0);
      continue;
    }
    word(v.instance + 1), word(v.primitive + 1);
    if (v.light_instance != PathVertex::kNone)
      word(v.light_instance + 1), word(v.light_primitive + 1), word(v.light_contributed);
    if (v.lobe != PathVertex::kNone) word(v.lobe);
    if (v.survived != PathVertex::kNone) word(v.survived);
  }
  return h;
}

TEST(ReferenceRenderer, PathsExplainSamples) {
  const Scene scene = decisions_scene();
  const auto renderer = make_reference_renderer(scene, {.seed = 9});
  const auto ids = all_ids(scene, {0, 30});
  const auto records = renderer->trace_samples(ids);
  std::vector<int> lobes(4, 0), contributed(2, 0), survived(2, 0);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto path = renderer->trace_path(ids[i]);
    ASSERT_EQ(path.size(), records[i].segments);
    EXPECT_EQ(fold(path), records[i].signature);
    const glm::vec3 difference = glm::abs(path.back().radiance - records[i].radiance);
    EXPECT_LE(difference.x + difference.y + difference.z, 1e-6f * (1.0f + glm::length(records[i].radiance)));
    for (const PathVertex& v : path) {
      if (v.lobe != PathVertex::kNone) ++lobes[v.lobe];
      if (v.light_contributed != PathVertex::kNone) ++contributed[v.light_contributed];
      if (v.survived != PathVertex::kNone) ++survived[v.survived];
    }
  }
  // The scene makes every decision both ways.
  for (const auto& counts : {lobes, contributed, survived})
    for (const int count : counts) EXPECT_GT(count, 20);
}

TEST(ReferenceRenderer, TurnsDoNotDependOnStrategy) {
  // The same sample index takes the same turns whatever nee and mis say (roulette looks at the throughput only).
  Scene scene = decisions_scene();
  const auto ids = all_ids(scene, {0, 10});
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> turns;
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    const auto renderer = make_reference_renderer(scene, {});
    auto& list = turns.emplace_back();
    for (const SampleId& id : ids)
      for (const PathVertex& v : renderer->trace_path(id)) list.emplace_back(v.instance, v.lobe);
  }
  EXPECT_EQ(turns[0], turns[1]);
  EXPECT_EQ(turns[0], turns[2]);
}

/// Share of roulettes survived, and the check that they are played from vertex `rr_depth` − 1 on.
double survival(const Scene& scene, std::uint32_t paths) {
  const auto renderer = make_reference_renderer(scene, {.seed = 4});
  double played = 0.0, survived = 0.0;
  for (std::uint32_t i = 0; i < paths; ++i) {
    const auto path = renderer->trace_path({0, i});
    for (std::size_t v = 0; v < path.size(); ++v) {
      const bool expected =
          path[v].lobe != PathVertex::kNone && path[v].lobe != 0u && v + 1 >= scene.integrator.rr_depth;
      EXPECT_EQ(path[v].survived != PathVertex::kNone, expected) << "path " << i << " vertex " << v;
      if (!expected) continue;
      played += 1.0, survived += path[v].survived;
    }
  }
  EXPECT_GT(played, 10000.0);
  return survived / played;
}

TEST(ReferenceRenderer, RouletteGoesByThroughputWhateverTheMedium) {
  // Inside a diffuse box of albedo 0.6 throughput after a bounce is 0.6 (0.6² at the first roulette, of 2), and 1 after
  // surviving: P(survive) is 0.36 first, 0.6 after that. In glass the squared index is taken out: always 0.99.
  Scene scene;
  scene.camera = pixel_camera({0.1, 0, 0}, {0, 0, 1}, 60, {0, 1, 0});
  scene.integrator.rr_depth = 2;
  scene.integrator.max_depth = 1000;
  add(scene, box(Vec3(-1.0), Vec3(1.0), true), diffuse(0.6));
  // Expected plays: 1 + 0.36/(1 − 0.6) = 1.9 a path; survivals: 0.36/(1 − 0.6) = 0.9.
  EXPECT_NEAR(survival(scene, 20000), 0.9 / 1.9, 0.015);  // 5 standard deviations
  scene.shapes[0] = Sphere{Vec3(0.0), 1.0};
  scene.materials[0].bsdf = DielectricBsdf{.int_ior = 1.8, .ext_ior = 1.0};
  scene.camera.world_from_camera = look_at({0, 0, -3}, {0, 0, 0}, {0, 1, 0});
  scene.camera.fov = 36;
  scene.integrator.rr_depth = 1;
  EXPECT_NEAR(survival(scene, 20000), 0.99, 0.003);
}

TEST(ReferenceRenderer, LongPathsAreRecordedUpToTheLimit) {
  Scene scene;
  scene.camera = pixel_camera({0, 0, 0}, {0, 0, 1}, 1e-6, {0, 1, 0});
  add(scene, box(Vec3(-1.0), Vec3(1.0), true), MirrorBsdf{});
  scene.integrator.max_depth = 1000;
  scene.integrator.rr_depth = 0;
  const auto renderer = make_reference_renderer(scene, {});
  EXPECT_EQ(renderer->trace_path({0, 0}).size(), 256u);
  EXPECT_EQ(renderer->trace_samples(std::vector<SampleId>{{0, 0}})[0].segments, 1000u);
}

TEST(ReferenceRenderer, ProgressReportsAndStopsAfterWholeIndices) {
  const Scene scene = decisions_scene();
  const auto renderer = make_reference_renderer(scene, {});
  Film film(scene.camera.width, scene.camera.height, kExponent);
  std::vector<RejectedSample> rejected;
  std::uint64_t last = 0, calls = 0;
  const auto caller = std::this_thread::get_id();
  const Progress stop_at_once = [&](std::uint64_t done, std::uint64_t total) {
    EXPECT_GE(done, last);
    EXPECT_EQ(total, 91u * 2000000u);
    EXPECT_EQ(std::this_thread::get_id(), caller);
    last = done;
    ++calls;
    return false;
  };
  const std::uint32_t end = renderer->render({0, 2000000}, film, stop_at_once, rejected);
  EXPECT_GT(end, 0u);
  EXPECT_LT(end, 2000000u);
  EXPECT_GE(calls, 2u);
  EXPECT_EQ(last, std::uint64_t{end} * 91u);
  for (const FilmPixel& pixel : film.pixels()) ASSERT_EQ(pixel.count, end);
  EXPECT_TRUE(render(scene, {0, end}).pixels() == film.pixels());
}

TEST(ReferenceRenderer, ExceptionsFromProgressReachTheCaller) {
  const Scene scene = decisions_scene();
  Film film(scene.camera.width, scene.camera.height, kExponent);
  std::vector<RejectedSample> rejected;
  const Progress fails = [](std::uint64_t, std::uint64_t) -> bool { throw Error(ErrorKind::interrupted, "enough"); };
  EXPECT_THROW(make_reference_renderer(scene, {})->render({0, 1}, film, fails, rejected), Error);
}

TEST(ReferenceRenderer, RejectedSamplesAreLocated) {
  // A lamp too bright for float32, visible in the middle of the image only.
  Scene scene;
  scene.camera.width = 40, scene.camera.height = 20, scene.camera.fov = 60;
  add(scene, Sphere{{0, 0, 5}, 0.5}, diffuse(0.0), Vec3(1e60));
  Film film(40, 20, kExponent);
  for (const unsigned threads : {1u, 3u}) {
    const ThreadCount guard(threads);
    film = Film(40, 20, kExponent);
    std::vector<RejectedSample> rejected;
    make_reference_renderer(scene, {})->render({0, 9}, film, {}, rejected);
    EXPECT_EQ(rejected.size(), 64u);
    EXPECT_GT(film.rejected(), 64u);
    for (std::size_t i = 0; i < rejected.size(); ++i) {
      EXPECT_GT(film.pixels()[rejected[i].id.pixel].rejected, 0u);
      EXPECT_EQ(rejected[i].segments, 1u);
      if (i > 0) {
        EXPECT_LT(std::pair(rejected[i - 1].id.sample, rejected[i - 1].id.pixel),
                  std::pair(rejected[i].id.sample, rejected[i].id.pixel));
      }
    }
  }
}

TEST(ReferenceRenderer, FilmOfAnotherSizeIsRefused) {
  Film film(3, 4, kExponent);
  std::vector<RejectedSample> rejected;
  EXPECT_THROW(make_reference_renderer(decisions_scene(), {})->render({0, 1}, film, {}, rejected), Error);
}

TEST(ReferenceRenderer, FiltersKeepAConstantImage) {
  using Type = ReconstructionFilter::Type;
  for (const Type type : {Type::box, Type::tent, Type::gaussian, Type::mitchell, Type::lanczos}) {
    Scene scene;
    scene.camera.width = scene.camera.height = 4;
    scene.camera.filter.type = type;
    scene.sky.top = scene.sky.horizon = Vec3(1.0);
    const Estimate e = estimate(scene, 20000);
    const double slack = type == Type::box ? 1e-7 : 2e-3;  // the tabulated density is constant between knots
    EXPECT_NEAR(e.mean, 1.0, slack + kMaxT * e.standard_error) << static_cast<int>(type);
  }
}

TEST(ReferenceRenderer, NamesItself) {
  const auto renderer = make_reference_renderer(decisions_scene(), {});
  EXPECT_EQ(renderer->device_name(), "reference");
  EXPECT_EQ(renderer->driver_name().rfind("double precision, etendue ", 0), 0u);
}

TEST(ReferenceRenderer, AnEmptySceneIsItsSky) {
  Scene scene;
  scene.camera.width = scene.camera.height = 2;
  scene.sky.top = scene.sky.horizon = Vec3(0.25);
  EXPECT_EQ(estimate(scene, 10).mean, 0.25);
}

}  // namespace
}  // namespace etendue::reference::test
