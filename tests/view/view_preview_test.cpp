/// The parts of the viewer without a browser: numbers on their way, poses, who may ask, files that change, and a render
/// that is steered.

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <thread>

#include <glm/gtc/packing.hpp>

#include "compile/compiled_scene.h"
#include "core/errors.h"
#include "etendue/etendue.h"
#include "view/guard.h"
#include "view/picture.h"
#include "view/pose.h"
#include "view/preview.h"
#include "view/watch.h"

namespace etendue::view {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(ViewPicture, HalvesAreTheNearest) {
  // Every half and the middles between them, with their neighbours.
  for (std::uint32_t bits = 0; bits < 0x7c00u; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    const float value = glm::unpackHalf1x16(half), above = glm::unpackHalf1x16(static_cast<std::uint16_t>(bits + 1));
    ASSERT_EQ(half_of(value), half);
    ASSERT_EQ(half_of(-value), half | 0x8000u);
    if (bits == 0x7bffu) break;
    const float middle = 0.5f * (value + above);
    ASSERT_EQ(half_of(std::nextafter(middle, 0.0f)), half) << middle;
    ASSERT_EQ(half_of(std::nextafter(middle, 1e9f)), half + 1u) << middle;
    ASSERT_EQ(half_of(middle), half + (half & 1u)) << middle;
  }
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(half_of(1e30f), 0x7bffu) << "bright is not infinite";
  EXPECT_EQ(half_of(kInfinity), 0x7c00u);
  EXPECT_EQ(half_of(-kInfinity), 0xfc00u);
  EXPECT_TRUE(std::isnan(glm::unpackHalf1x16(half_of(std::numeric_limits<float>::quiet_NaN()))));
}

TEST(ViewPicture, MeanAndErrorLieInOrder) {
  Film film(2, 1, 0);
  film.pixels()[0].add({1.0f, 2.0f, 3.0f}, 0);
  film.pixels()[1].add({4.0f, 5.0f, 6.0f}, 0);
  film.pixels()[1].add({4.0f, 7.0f, 6.0f}, 0);
  const auto halves = [](const Bytes& bytes, std::size_t i) {
    return glm::unpackHalf1x16(static_cast<std::uint16_t>(static_cast<unsigned char>((*bytes)[2 * i]) |
                                                          static_cast<unsigned char>((*bytes)[2 * i + 1]) << 8));
  };
  const Bytes mean = packed(film, Channel::mean), error = packed(film, Channel::error);
  ASSERT_EQ(mean->size(), 12u);
  EXPECT_EQ(halves(mean, 1), 2.0f);
  EXPECT_EQ(halves(mean, 4), 6.0f);
  EXPECT_EQ(halves(error, 4), 1.0f);
  EXPECT_EQ(halves(error, 3), 0.0f);
  EXPECT_TRUE(std::isinf(halves(error, 0)));
}

// Scaled, mirrored and rolled, as transforms of scene files may be.
std::vector<glm::dmat4> placements() {
  const auto placed = [](glm::dvec3 x, glm::dvec3 y, glm::dvec3 z, glm::dvec3 eye) {
    return glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(z, 0), glm::dvec4(eye, 1));
  };
  const double s = std::sqrt(0.5);
  return {placed({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, -6}), placed({-2, 0, 0}, {0, 3, 0}, {0, 0, 1}, {4, 5, 6}),
          placed({s, s, 0}, {-s, s, 0}, {0, 0, 1}, {0, 0, -3}), placed({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, 9, 0}),
          placed({1, 0, 0.5}, {0, 1, 0}, {0, 0.2, 1}, {1, 2, 3})};
}

TEST(ViewPose, AMoveThereAndBackIsNone) {
  Bounds bounds;
  bounds.add({-1, -1, -1});
  bounds.add({1, 1, 1});
  for (const glm::dmat4& placement : placements()) {
    Camera camera;
    camera.world_from_camera = placement;
    const Pose own = pose_of(camera, bounds);
    EXPECT_EQ(pose_complaint(own), "");
    EXPECT_EQ(moved(camera, own, own).world_from_camera, placement);
    Pose there = own;
    there.eye += glm::dvec3(0.3, 0.2, -0.1);
    const Camera away = moved(camera, own, there);
    EXPECT_EQ(glm::dvec3(away.world_from_camera[3]), there.eye);
    EXPECT_GT(glm::dot(glm::normalize(glm::dvec3(away.world_from_camera[2])), glm::normalize(there.target - there.eye)),
              1.0 - 1e-12)
        << "it looks at its target";
    const Camera back = moved(away, there, own);
    for (int i = 0; i < 4; ++i)
      EXPECT_LT(glm::length(back.world_from_camera[i] - placement[i]), 1e-12) << "scales and mirrors are kept";
  }
}

TEST(ViewPose, UprightCamerasOrbitAboutTheAxisTheyStandBy) {
  Camera camera;
  camera.world_from_camera = placements()[0];
  EXPECT_EQ(pose_of(camera, {}).up, glm::dvec3(0, 1, 0));
  camera.world_from_camera = placements()[2];  // rolled by 45°
  EXPECT_NEAR(pose_of(camera, {}).up.x, -std::sqrt(0.5), 1e-12);
}

TEST(ViewGuard, NamesOfThisMachineOnly) {
  const Guard guard("token", "127.0.0.1");
  const auto status = [&](const std::string& host, const std::string& path, const std::string& origin = "") {
    return guard.admit({.method = "GET", .path = path, .host = host, .origin = origin}).status;
  };
  EXPECT_EQ(status("localhost:1", "/token/"), 200);
  EXPECT_EQ(status("localhost:1", "/tokens/"), 404);
  EXPECT_EQ(status("localhost:1", "/token"), 404);
  EXPECT_EQ(status("192.0.2.1", "/token/"), 421);
  EXPECT_EQ(status("localhost:1", "/token/", "http://localhost:1"), 200);
  EXPECT_EQ(status("localhost:1", "/token/", "http://localhost:2"), 403);
  EXPECT_EQ(random_token().size(), 32u);
  EXPECT_NE(random_token(), random_token());
}

class ViewFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = ::testing::TempDir() + "etendue-view-XXXXXX";
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name) << text;
    return folder_ + "/" + name;
  }
  std::string folder_;
};

TEST_F(ViewFiles, AChangeIsToldOnceAndWhenItRests) {
  const std::string path = write("a", "1");
  FileStamps read = {{path, stamp_of(path)}, {folder_ + "/missing", {}}};
  FileWatch watch;
  EXPECT_FALSE(watch.changed(read));
  EXPECT_FALSE(watch.changed(read));
  write("a", "22");
  EXPECT_FALSE(watch.changed(read)) << "it may be going on";
  EXPECT_TRUE(watch.changed(read));
  EXPECT_FALSE(watch.changed(read)) << "told already";
  read[path] = stamp_of(path);
  EXPECT_FALSE(watch.changed(read));
  write("missing", "here");
  EXPECT_FALSE(watch.changed(read));
  EXPECT_TRUE(watch.changed(read));
}

State until(Preview& preview, const std::function<bool(const State&)>& condition) {
  State state;
  const auto end = std::chrono::steady_clock::now() + seconds(100);
  while (std::chrono::steady_clock::now() < end) {
    state = preview.wait(state.version, false, milliseconds(500));
    if (condition(state)) return state;
  }
  ADD_FAILURE() << "not within 100 s: " << state.problem;
  return state;
}

Scene small_scene() {
  return read_scene(SCENES_DIR "/cbox-sphere.xml",
                    {.overrides = {{"camera.width", "320"}, {"camera.height", "240"}, {"sampler.sampleCount", "3"}}});
}

TEST(ViewPreview, ACameraThatMovesCompilesNothingAgain) {
  const std::uint64_t before = scene_compilations();
  Preview preview({.read_scene = small_scene, .device = {}});
  const State first = until(preview, [](const State& s) { return s.picture > 0; });
  EXPECT_LT(first.width, first.full_width) << "coarse, to be there soon";
  State state = until(preview, [](const State& s) { return s.phase == Phase::done; });
  EXPECT_EQ(state.width, 320u);
  EXPECT_EQ(state.samples, 3u);
  for (int i = 1; i <= 8; ++i) {
    Move move{.pose = state.pose, .fov = 20.0 + i, .going_on = i < 8, .mover = 5};
    move.pose.eye.x += 0.01 * i;
    const std::uint64_t picture = state.picture;
    preview.move(move);
    state = until(preview, [&](const State& s) { return s.picture > picture && s.pose == move.pose; });
    EXPECT_EQ(state.mover, 5u);
  }
  state = until(preview, [](const State& s) { return s.phase == Phase::done; });
  EXPECT_EQ(state.camera.fov, 28.0);
  EXPECT_EQ(scene_compilations() - before, 1u);
}

TEST(ViewPreview, ASnapshotIsWhatRenderWrites) {
  Preview preview({.read_scene = small_scene, .device = {}, .seed = 7});
  until(preview, [](const State& s) { return s.phase == Phase::done; });
  const std::string folder = ::testing::TempDir();
  write_exr(folder + "/view-once.exr", picture_of(render(small_scene(), {.seed = 7})));
  std::ifstream file(folder + "/view-once.exr", std::ios::binary);
  const std::string rendered{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(preview.snapshot(".exr") == rendered) << "the same bytes";
  EXPECT_TRUE(preview.snapshot(".png").starts_with("\x89PNG"));
  EXPECT_THROW(preview.snapshot(".txt"), Error);
}

TEST(ViewPreview, TheLastGoodPictureOutlivesABrokenScene) {
  std::atomic<bool> broken = false;
  Preview preview({.read_scene =
                       [&] {
                         if (broken) throw Error(ErrorKind::scene, "scene.xml:3:4: wrong");
                         return small_scene();
                       },
                   .device = {}});
  const State good = until(preview, [](const State& s) { return s.phase == Phase::done; });
  broken = true;
  preview.reload();
  State state = until(preview, [](const State& s) { return !s.problem.empty() && s.phase != Phase::opening; });
  EXPECT_EQ(state.problem, "scene.xml:3:4: wrong");
  EXPECT_EQ(state.mean, good.mean);
  EXPECT_EQ(state.phase, Phase::done);
  broken = false;
  preview.reload();
  state = until(preview, [](const State& s) { return s.problem.empty() && s.phase == Phase::done; });
  EXPECT_EQ(*state.mean, *good.mean);
}

TEST(ViewPreview, ABrokenSceneFromTheBeginningCanBeMended) {
  std::atomic<bool> broken = true;
  Preview preview({.read_scene =
                       [&] {
                         if (broken) throw Error(ErrorKind::scene, "scene.xml:1:1: wrong");
                         return small_scene();
                       },
                   .device = {}});
  const State state = until(preview, [](const State& s) { return s.phase == Phase::stopped; });
  EXPECT_EQ(state.picture, 0u);
  EXPECT_THROW(preview.snapshot(".exr"), Error);
  preview.reset_camera();  // has to wait, too
  broken = false;
  preview.reload();
  until(preview, [](const State& s) { return s.phase == Phase::done; });
}

TEST(ViewPreview, RestsWhenNobodyLooks) {
  Preview preview({.read_scene =
                       [] {
                         Scene scene = small_scene();
                         scene.sampler.sample_count = 1u << 20;
                         return scene;
                       },
                   .device = {},
                   .unwatched = milliseconds(300)});
  until(preview, [](const State& s) { return s.samples > 1; });
  std::this_thread::sleep_for(seconds(2));
  const State rested = preview.wait(0, false, {});
  EXPECT_EQ(rested.phase, Phase::resting);
  until(preview, [&](const State& s) { return s.samples > rested.samples; });
}

}  // namespace
}  // namespace etendue::view
