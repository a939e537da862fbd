/// The parts of the viewer that need no browser: encoding of numbers, poses, access control, changed files, and
/// steering a render.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <thread>

#include <glm/gtc/packing.hpp>

#include "cli/path_words.h"
#include "compile/compiled_scene.h"
#include "core/errors.h"
#include "etendue/etendue.h"
#include "reference/bsdf.h"
#include "scene/light_sources.h"
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
  // Every half-precision number, the midpoints between them, and their neighbours.
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

// Scaled, mirrored and rolled, as transforms in scene files may be.
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

State until(Preview& preview, const std::function<bool(const State&)>& condition, const Looked& looked = {}) {
  State state;
  const auto end = std::chrono::steady_clock::now() + seconds(100);
  while (std::chrono::steady_clock::now() < end) {
    state = preview.wait(state.version, looked, milliseconds(500));
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

// A sphere of radius 1 at (0, 0, 5) in front of a camera at the origin that looks along +Z and is scaled by 2.
Scene sphere_scene() {
  Scene scene;
  scene.name = "sphere";
  scene.camera.width = scene.camera.height = 65;
  scene.camera.fov = 40.0;
  scene.camera.far_clip = 1e3;
  scene.camera.world_from_camera = glm::dmat4(2.0);
  scene.camera.world_from_camera[3] = glm::dvec4(0, 0, 0, 1);
  scene.sampler.sample_count = 4;
  scene.sky.top = scene.sky.horizon = glm::dvec3(1.0);
  scene.add(Sphere{.center = {0, 0, 5}, .radius = 1});
  return scene;
}

TEST(ViewPreview, APixelLeadsToItsPoint) {
  Preview preview({.read_scene = sphere_scene, .device = {}});
  until(preview, [](const State& s) { return s.phase == Phase::done; });
  const Point middle = preview.point_at(32, 32);
  ASSERT_TRUE(middle.hit);
  EXPECT_LT(glm::length(middle.position - glm::dvec3(0, 0, 4)), 0.05);
  EXPECT_NEAR(middle.focus, 2.0, 0.02) << "camera units";
  EXPECT_FALSE(preview.point_at(0, 0).hit);
  EXPECT_THROW(preview.point_at(65, 0), Error);
  const State after = preview.wait(0, {}, {});
  Move move{.pose = after.pose, .aperture = 0.1, .focus = middle.focus};
  preview.move(move);
  const State lens = until(preview, [](const State& s) { return s.camera.aperture.radius == 0.1; });
  EXPECT_EQ(lens.camera.type, Camera::Type::thin_lens);
  EXPECT_EQ(lens.camera.aperture.focus_distance, middle.focus);
  preview.reset_camera();
  EXPECT_EQ(until(preview, [](const State& s) { return s.camera.aperture.radius == 0.0; }).camera.type,
            Camera::Type::perspective);
}

TEST(ViewPreview, DeviceAndReferenceTellTheSamePath) {
  Preview preview({.read_scene = small_scene, .device = {}, .seed = 3});
  const State done = until(preview, [](const State& s) { return s.phase == Phase::done; });
  for (std::uint32_t sample = 0; sample < 8; ++sample) {
    const Told device = preview.explain(160, 200, sample), reference = preview.explain_by_reference(160, 200, sample);
    ASSERT_EQ(device.path.size(), reference.path.size());
    for (std::size_t i = 0; i < device.path.size(); ++i) {
      EXPECT_EQ(device.path[i].instance, reference.path[i].instance);
      EXPECT_EQ(device.path[i].lobe, reference.path[i].lobe);
    }
  }
  EXPECT_EQ(*preview.wait(0, {}, {}).mean, *done.mean) << "the picture is as it was";
}

TEST(ViewPreview, LayersComeWhenSomebodyLooks) {
  Preview preview({.read_scene = sphere_scene, .device = {}});
  until(preview, [](const State& s) { return s.phase == Phase::done; });
  const State state =
      until(preview, [](const State& s) { return s.layers.contains("depth"); }, {.error = false, .aov = Aov::depth});
  const Layer& depth = *state.layers.at("depth");
  ASSERT_EQ(depth.components, 1u);
  ASSERT_EQ(depth.values->size(), 65u * 65u * sizeof(float));
  float middle = 0;
  std::memcpy(&middle, depth.values->data() + (32 * 65 + 32) * sizeof middle, sizeof middle);
  EXPECT_NEAR(middle, 4.0, 0.01);
  preview.reset_camera();
  until(preview, [](const State& s) { return s.layers.empty(); });
}

TEST(ViewPreview, ParametersOfTheIntegratorCompileNothingOfTheScene) {
  const std::uint64_t before = scene_compilations();
  Preview preview({.read_scene = small_scene, .device = {}});
  until(preview, [](const State& s) { return s.phase == Phase::done; });
  preview.change({.max_depth = 2, .rr_depth = {}, .nee = false, .mis = {}});
  const State state =
      until(preview, [](const State& s) { return s.integrator.max_depth == 2 && s.phase == Phase::done; });
  EXPECT_FALSE(state.integrator.nee);
  Scene scene = small_scene();
  scene.integrator.max_depth = 2;
  scene.integrator.nee = false;
  const FilmFile film = render(scene, {});
  EXPECT_EQ(*state.mean, *packed(film.film, Channel::mean));
  EXPECT_EQ(scene_compilations() - before, 2u) << "one of them for the render beside it";
}

TEST(ViewPreview, ChangesOfTwoParametersAtOnceBothCount) {
  Preview preview({.read_scene = small_scene, .device = {}});
  until(preview, [](const State& s) { return s.phase == Phase::done; });
  preview.change({.max_depth = 3, .rr_depth = {}, .nee = {}, .mis = {}});
  preview.change({.max_depth = {}, .rr_depth = {}, .nee = false, .mis = {}});
  preview.change({.max_depth = {}, .rr_depth = {}, .nee = {}, .mis = false});
  const State state = until(preview, [](const State& s) { return !s.integrator.mis && s.phase == Phase::done; });
  EXPECT_EQ(state.integrator.max_depth, 3u);
  EXPECT_FALSE(state.integrator.nee);
}

std::uint32_t row_of(const Preview& preview, const std::string& name) {
  const Palette palette = preview.palette();
  const auto found = std::ranges::find(*palette.materials, name, &Material::name);
  EXPECT_NE(found, palette.materials->end()) << name;
  return static_cast<std::uint32_t>(found - palette.materials->begin());
}

TEST(ViewPreview, NumbersOfMaterialsCompileNothingOfTheScene) {
  const std::uint64_t before = scene_compilations();
  Preview preview({.read_scene = small_scene, .device = {}});
  const State own = until(preview, [](const State& s) { return s.phase == Phase::done; });
  const std::uint32_t row = row_of(preview, small_scene().materials.front().name);
  preview.change({.row = row, .name = "albedo", .value = glm::dvec3(0.9, 0.1, 0.2)});
  const State state =
      until(preview, [&](const State& s) { return s.materials > own.materials && s.phase == Phase::done; });
  EXPECT_EQ(scene_compilations() - before, 1u);
  Scene scene = small_scene();
  ASSERT_TRUE(set_number(scene.materials[row], "albedo", {0.9, 0.1, 0.2}));
  EXPECT_EQ(*state.mean, *packed(render(scene, {}).film, Channel::mean));
  const std::string folder = ::testing::TempDir();
  write_exr(folder + "/view-material.exr", picture_of(render(scene, {})));
  std::ifstream file(folder + "/view-material.exr", std::ios::binary);
  EXPECT_TRUE(preview.snapshot(".exr") == std::string(std::istreambuf_iterator<char>(file), {}))
      << "and the hash is that of the changed scene";
  preview.change(NumberChange{.row = row, .name = "albedo"});
  EXPECT_EQ(
      *until(preview, [&](const State& s) { return s.materials > state.materials && s.phase == Phase::done; }).mean,
      *own.mean)
      << "as in the file";
}

TEST(ViewPreview, NumbersOfLightsAreThoseOfTheFile) {
  const std::uint64_t before = scene_compilations();
  Preview preview({.read_scene = small_scene, .device = {}});
  const State own = until(preview, [](const State& s) { return s.phase == Phase::done; });
  const auto done = [&](std::uint64_t lights) {
    return until(preview, [&](const State& s) { return s.lights > lights && s.phase == Phase::done; });
  };
  preview.explain_by_reference(32, 32, 0);
  const auto sky = count_of(*preview.palette().lights) - 1;
  preview.change_light({.row = 0, .name = "radiance", .value = glm::dvec3(300.0, 20.0, 1.0)});
  const State bright = done(own.lights);
  preview.change_light({.row = sky, .name = "top", .value = glm::dvec3(0.0, 0.0, 4.0)});
  const State both = done(bright.lights);
  EXPECT_EQ(scene_compilations() - before, 1u) << "the tree of the shapes was built once";
  Scene scene = small_scene();
  scene.emitters[0].radiance.value = {300.0, 20.0, 1.0};
  EXPECT_EQ(*bright.mean, *packed(render(scene, {}).film, Channel::mean));
  scene.sky.top = {0.0, 0.0, 4.0};
  EXPECT_EQ(*both.mean, *packed(render(scene, {}).film, Channel::mean));
  const std::string file = ::testing::TempDir() + "/view-light.exr";
  write_exr(file, picture_of(render(scene, {})));
  std::ifstream bytes(file, std::ios::binary);
  EXPECT_TRUE(preview.snapshot(".exr") == std::string(std::istreambuf_iterator<char>(bytes), {}))
      << "and the hash is that of the changed scene";
  const Told device = preview.explain(32, 32, 1), reference = preview.explain_by_reference(32, 32, 1);
  ASSERT_EQ(device.path.size(), reference.path.size());
  EXPECT_LT(glm::length(device.path.back().radiance - reference.path.back().radiance),
            1e-3f * glm::length(reference.path.back().radiance) + 1e-6f);
  preview.change({.row = 0, .name = "albedo", .value = glm::dvec3(0.9, 0.1, 0.2)});
  ASSERT_TRUE(set_number(scene.materials[0], "albedo", {0.9, 0.1, 0.2}));
  const State painted =
      until(preview, [&](const State& s) { return s.materials > both.materials && s.phase == Phase::done; });
  EXPECT_EQ(*painted.mean, *packed(render(scene, {}).film, Channel::mean)) << "materials change beside lights";
  preview.change(NumberChange{.row = 0});
  for (const std::uint32_t row : {0u, sky}) preview.change_light(NumberChange{.row = row});
  EXPECT_EQ(*done(both.lights).mean, *own.mean) << "as in the file";
}

TEST(ViewPreview, LightsOutOfRangeAreRefused) {
  Preview preview({.read_scene = small_scene, .device = {}});
  const State own = until(preview, [](const State& s) { return s.phase == Phase::done; });
  const auto refused = [&](const NumberChange& change) {
    try {
      preview.change_light(change);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refused({.row = 0, .name = "radiance", .value = glm::dvec3(-1.0)}).find("out of range"), std::string::npos);
  EXPECT_NE(refused({.row = 0, .name = "scale", .value = glm::dvec3(2.0)}).find("no number 'scale'"),
            std::string::npos);
  EXPECT_NE(refused({.row = 0, .name = "", .value = glm::dvec3(2.0)}).find("no number ''"), std::string::npos)
      << "a value is no value for all of them";
  EXPECT_NE(refused({.row = 4000, .name = "radiance", .value = {}}).find("There is no light 4000"), std::string::npos);
  EXPECT_EQ(preview.wait(0, {}, {}).lights, own.lights);
}

TEST(ViewPreview, NumbersOutOfRangeAreRefusedAndChangeNothing) {
  Preview preview({.read_scene = small_scene, .device = {}});
  const State own = until(preview, [](const State& s) { return s.phase == Phase::done; });
  const auto refused = [&](const NumberChange& change) {
    try {
      preview.change(change);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::uint32_t row = row_of(preview, small_scene().materials.front().name);
  EXPECT_NE(refused({.row = row, .name = "albedo", .value = glm::dvec3(NAN)}).find("is not finite"), std::string::npos);
  EXPECT_NE(refused({.row = row, .name = "alpha", .value = glm::dvec3(0.5)}).find("no number 'alpha'"),
            std::string::npos);
  EXPECT_NE(refused({.row = 4000, .name = "albedo", .value = {}}).find("There is no material 4000"), std::string::npos);
  EXPECT_EQ(preview.wait(0, {}, {}).materials, own.materials);
}

// A brushed surface needs a different table of directions, so the scene is compiled again, also for the reference.
TEST(ViewPreview, ABrushedMaterialIsShownAsWell) {
  const auto read = [] {
    Scene scene = sphere_scene();
    scene.materials.push_back({PrincipledBsdf{.metallic = 1.0}, {}, "metal", {}});
    scene.instances.front().material = static_cast<std::uint32_t>(scene.materials.size() - 1);
    return scene;
  };
  Preview preview({.read_scene = read, .device = {}});
  const State own = until(preview, [](const State& s) { return s.phase == Phase::done; });
  preview.explain_by_reference(32, 32, 0);
  const std::uint32_t row = row_of(preview, "metal");
  EXPECT_EQ(preview.point_at(32, 32).material, row);
  preview.change({.row = row, .name = "anisotropic", .value = glm::dvec3(0.8)});
  const State state =
      until(preview, [&](const State& s) { return s.materials > own.materials && s.phase == Phase::done; });
  Scene scene = read();
  ASSERT_TRUE(set_number(scene.materials[row], "anisotropic", glm::dvec3(0.8)));
  EXPECT_EQ(*state.mean, *packed(render(scene, {}).film, Channel::mean));
  const Told device = preview.explain(32, 32, 1), reference = preview.explain_by_reference(32, 32, 1);
  ASSERT_EQ(device.path.size(), reference.path.size());
  EXPECT_LT(glm::length(device.path[0].to - reference.path[0].to), 1e-3f);
}

TEST(ViewPages, EveryLobeHasAName) {
  std::set<std::string> names = {"-"};
  for (std::uint32_t lobe = 0; lobe <= static_cast<std::uint32_t>(reference::Lobe::diffuse_transmission); ++lobe) {
    PathVertex vertex;
    vertex.lobe = lobe;
    EXPECT_TRUE(names.insert(cli::words_of(vertex).lobe).second) << lobe;
  }
}

// A crop shows what that part of the film shows, and nothing else.
TEST(ViewPreview, ACropIsAFilmOfThatPart) {
  Preview preview({.read_scene = small_scene, .device = {}});
  until(preview, [](const State& s) { return s.phase == Phase::done; });
  preview.set_crop(Crop{80, 60, 100, 50});
  const State state = until(preview, [](const State& s) { return s.crop && s.phase == Phase::done; });
  EXPECT_EQ(state.width, 100u);
  EXPECT_EQ(state.full_height, 50u);
  Scene scene = small_scene();
  scene.camera.window = {.origin = {0.25, 0.25}, .size = {100.0 / 320.0, 50.0 / 240.0}};
  scene.camera.width = 100;
  scene.camera.height = 50;
  EXPECT_EQ(*state.mean, *packed(render(scene, {}).film, Channel::mean));
  preview.set_crop(Crop{300, 230, 4000, 4000});
  EXPECT_EQ(until(preview, [](const State& s) { return s.crop && s.crop->x == 300; }).crop, (Crop{300, 230, 20, 10}));
  preview.set_crop(Crop{0, 0, 320, 240});
  until(preview, [](const State& s) { return !s.crop && s.phase == Phase::done && s.width == 320; });
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

Scene small_scene_unless(bool broken, const char* sentence) {
  if (broken) throw Error(ErrorKind::scene, sentence);
  return small_scene();
}

/// Finds a film of 241 rows too large, as a device may once it has let go of the last scene.
class SmallDevice final : public Renderer {
 public:
  explicit SmallDevice(std::unique_ptr<Renderer> inner) : inner_(std::move(inner)) {}
  std::string device_name() const override { return inner_->device_name(); }
  std::string driver_name() const override { return inner_->driver_name(); }
  void set_view(const View& view, const RenderSettings& settings) override { inner_->set_view(view, settings); }
  void set_materials(const std::vector<Material>& materials) override { inner_->set_materials(materials); }
  void set_scene(const SharedScene& scene, const RenderSettings& settings) override {
    if (scene.scene().camera.height == 241) {
      inner_.reset();
      throw Error(ErrorKind::lost, "It does not fit.");
    }
    inner_->set_scene(scene, settings);
  }
  std::uint32_t render(SampleRange range, Film& film, const Progress& progress,
                       std::vector<RejectedSample>& rejected) override {
    return inner_->render(range, film, progress, rejected);
  }
  std::vector<SampleRecord> trace_samples(std::span<const SampleId> ids) override { return inner_->trace_samples(ids); }
  std::vector<PathVertex> trace_path(SampleId id) override { return inner_->trace_path(id); }

 private:
  std::unique_ptr<Renderer> inner_;
};

TEST(ViewPreview, ASceneThatDoesNotFitLeavesTheLastGoodOne) {
  std::atomic<std::uint32_t> height = 240;
  std::atomic<int> opened = 0;
  const auto read = [&] {
    Scene scene = small_scene();
    scene.camera.height = height;
    return scene;
  };
  const auto open = [&](const SharedScene& scene, const RenderSettings& settings) {
    ++opened;
    return std::make_unique<SmallDevice>(open_renderer(scene, {}, settings));
  };
  Preview preview({.read_scene = read, .device = {}, .open = open});
  const State own = until(preview, [](const State& s) { return s.phase == Phase::done; });
  preview.change({.row = 0, .name = "albedo", .value = glm::dvec3(0.1, 0.8, 0.3)});
  until(preview, [&](const State& s) { return s.materials > own.materials; });
  preview.change_light({.row = 0, .name = "radiance", .value = glm::dvec3(9.0, 20.0, 1.0)});
  const State good = until(preview, [&](const State& s) { return s.lights > own.lights && s.phase == Phase::done; });
  height = 241;
  preview.reload();
  const State state = until(preview, [](const State& s) { return !s.problem.empty() && s.phase == Phase::done; });
  EXPECT_EQ(state.loads, good.loads);
  EXPECT_EQ(state.full_height, 240u);
  EXPECT_EQ(*state.mean, *good.mean) << "with what was changed in it";
  EXPECT_EQ(opened, 2);
  height = 240;
  preview.reload();
  const State again = until(preview, [&](const State& s) { return s.loads > good.loads && s.phase == Phase::done; });
  EXPECT_TRUE(again.problem.empty());
  EXPECT_EQ(*again.mean, *own.mean);
  EXPECT_EQ(opened, 2) << "a scene that was read again stays on its device";
}

TEST(ViewPreview, TheLastGoodPictureOutlivesABrokenScene) {
  std::atomic<bool> broken = false;
  Preview preview({.read_scene = [&] { return small_scene_unless(broken, "scene.xml:3:4: wrong"); }, .device = {}});
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
  Preview preview({.read_scene = [&] { return small_scene_unless(broken, "scene.xml:1:1: wrong"); }, .device = {}});
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
  const State rested = preview.wait(0, {}, {});
  EXPECT_EQ(rested.phase, Phase::resting);
  until(preview, [&](const State& s) { return s.samples > rested.samples; });
}

}  // namespace
}  // namespace etendue::view
