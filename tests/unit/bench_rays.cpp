/// The rays of the bench, the verdict on their hits, and the numbers made of repetitions.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>
#include <tuple>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "bench/export.h"
#include "bench/ray_check.h"
#include "bench/ray_sets.h"
#include "bench/report.h"
#include "compile/normalization.h"
#include "core/errors.h"
#include "reference/ray_caster.h"
#include "reference_scenes.h"

namespace etendue {
namespace {

using reference::test::add;
using reference::test::box;
using reference::test::diffuse;
using reference::test::look_at;
using reference::test::quad;

Placement place(const Scene& scene) {
  const Normalization n = find_normalization(scene);
  return {n.center, n.scale};
}

// A room of side 4 around a sphere, far from the origin and in other units; the lamp is a quad below the ceiling.
Scene room(bool lamp = true) {
  const glm::dvec3 at(300.0, -20.0, 70.0);
  Scene scene;
  add(scene, box(at - 2.0, at + 2.0, true), diffuse(0.5));
  add(scene, Sphere{at + glm::dvec3(0.3, -0.2, 0.2), 0.8}, diffuse(0.5));
  if (lamp) {
    add(scene, quad(at + glm::dvec3(-0.5, 1.9, -0.5), glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1)), diffuse(0.0),
        glm::dvec3(10.0));
  }
  scene.camera.width = 120;
  scene.camera.height = 80;
  scene.camera.fov = 60.0;
  scene.camera.world_from_camera = look_at(at + glm::dvec3(0.0, 0.0, -1.8), at, glm::dvec3(0, 1, 0));
  scene.integrator.max_depth = 3;
  return scene;
}

const RaySet& find(const std::vector<RaySet>& sets, const std::string& kind, bool shuffled = false) {
  return *std::ranges::find_if(sets, [&](const RaySet& s) { return s.kind == kind && s.shuffled == shuffled; });
}

TEST(BenchSpread, MedianOfOddAndEvenCounts) {
  EXPECT_EQ(spread_of({}).count, 0u);
  const Spread odd = spread_of({3, 1, 2});
  EXPECT_EQ(odd.median, 2);
  EXPECT_EQ(odd.min, 1);
  EXPECT_EQ(odd.max, 3);
  EXPECT_EQ(spread_of({4, 1, 2, 10}).median, 3);
}

TEST(BenchRays, PrimaryRaysCoverTheFilmOnce) {
  const Scene scene = room();
  const auto caster = make_reference_ray_caster(scene, place(scene));
  const auto sets = make_ray_sets(scene, *caster, {.count = 6000});
  const auto& rays = find(sets, "primary").rays;
  EXPECT_LE(rays.size(), 6000u);
  EXPECT_GE(rays.size(), 4500u);
  std::set<std::pair<float, float>> directions;
  double widest = 0.0;
  for (const CastRay& ray : rays) {
    EXPECT_NEAR(glm::length(ray.d), 1.0f, 1e-6f);
    EXPECT_EQ(ray.o, rays.front().o);
    widest = std::max(widest, std::abs(static_cast<double>(ray.d.x) / ray.d.z));  // the camera looks along +Z
    directions.emplace(ray.d.x, ray.d.y);
  }
  EXPECT_EQ(directions.size(), rays.size());
  // The outermost pixel centre of a film about 90 pixels wide.
  EXPECT_LT(widest, std::tan(glm::radians(30.0)));
  EXPECT_GT(widest, std::tan(glm::radians(30.0)) * (1.0 - 1.0 / 80.0));
}

TEST(BenchRays, BouncesFollowTheCosineAndShadowsEndAtTheLamp) {
  const Scene scene = room();
  const Placement placement = place(scene);
  const auto caster = make_reference_ray_caster(scene, placement);
  const auto sets = make_ray_sets(scene, *caster, {.count = 40000});
  ASSERT_EQ(sets.size(), 6u);
  const auto& primary = find(sets, "primary").rays;
  const auto& bounces = find(sets, "diffuse").rays;
  const auto& shadows = find(sets, "shadow").rays;
  ASSERT_EQ(bounces.size(), primary.size()) << "the room is closed";
  ASSERT_EQ(shadows.size(), primary.size());
  caster->load(bounces);
  caster->cast(RayQuery::closest);
  std::size_t escaped = 0;
  for (const CastHit& hit : caster->hits()) escaped += hit.instance == CastHit::kNone;
  EXPECT_EQ(escaped, 0u) << "the room is closed";
  // On the wall opposite, the mean cosine of a cosine-distributed direction is 2/3.
  double cosines = 0.0, count = 0.0;
  const auto world_z = [&](const CastRay& ray) { return ray.o.z / placement.scale + placement.center.z; };
  for (const CastRay& ray : bounces) {
    if (world_z(ray) < 71.999) continue;
    cosines -= ray.d.z;
    ++count;
  }
  ASSERT_GT(count, 1000.0);
  EXPECT_NEAR(cosines / count, 2.0 / 3.0, 5.0 * 0.24 / std::sqrt(count));
  for (const CastRay& ray : shadows) {
    const glm::dvec3 end = (glm::dvec3(ray.o) + static_cast<double>(ray.t_max) * glm::dvec3(ray.d)) / placement.scale +
                           placement.center - glm::dvec3(300.0, -20.0, 70.0);
    EXPECT_NEAR(end.y, 1.9, 1e-4);
    EXPECT_LT(std::max(std::abs(end.x), std::abs(end.z)), 0.5001);
  }
  // Most of the room sees the lamp.
  caster->load(shadows);
  caster->cast(RayQuery::any);
  std::size_t occluded = 0;
  for (const CastHit& hit : caster->hits()) occluded += hit.instance != CastHit::kNone;
  EXPECT_LT(occluded, shadows.size() / 2);
  EXPECT_GT(occluded, 0u);
}

// Three lamps in one plane, seen from the front, and a floor when wanted.
Scene wall_of_lamps(bool floor) {
  Scene scene;
  for (const double x : {-3.0, 0.0, 3.0})
    add(scene, quad({x - 1, 0, 0}, {2, 0, 0}, {0, 2, 0}), diffuse(0.0), glm::dvec3(1.0));
  if (floor) add(scene, quad({-5, 0, 0}, {0, 0, 8}, {10, 0, 0}), diffuse(0.5));
  scene.camera.world_from_camera = look_at({0, 1.5, 9}, {0, 0.8, 0}, {0, 1, 0});
  scene.camera.fov = 50.0;
  return scene;
}

TEST(BenchRays, NoShadowRayRunsInThePlaneOfItsEnds) {
  const Scene scene = wall_of_lamps(true);
  const Placement placement = place(scene);
  const auto caster = make_reference_ray_caster(scene, placement);
  const auto sets = make_ray_sets(scene, *caster, {.count = 20000});
  const auto &shadows = find(sets, "shadow").rays, &bounces = find(sets, "diffuse").rays;
  EXPECT_GT(shadows.size(), bounces.size() / 4) << "from the floor";
  EXPECT_LT(shadows.size(), bounces.size() / 4 * 3) << "not from lamp to lamp";
  for (const CastRay& ray : shadows) {
    EXPECT_LT(ray.d.z * ray.t_max, -1e-6f) << "toward the lamps";
    EXPECT_GT(ray.d.y * ray.t_max, 1e-6f) << "off the floor";
  }
  const Scene alone = wall_of_lamps(false);
  const auto second = make_reference_ray_caster(alone, place(alone));
  EXPECT_EQ(make_ray_sets(alone, *second, {.count = 20000}).size(), 4u)
      << "primary and diffuse: no lamp lights another";
}

TEST(BenchRays, ShuffledRaysAreTheSameRays) {
  const Scene scene = room(false);
  const auto caster = make_reference_ray_caster(scene, place(scene));
  const auto sets = make_ray_sets(scene, *caster, {.count = 4000, .seed = 3});
  for (const char* kind : {"primary", "diffuse", "shadow"}) {
    const auto key = [](const CastRay& r) { return std::tuple(r.o.x, r.o.y, r.o.z, r.d.x, r.d.y, r.d.z, r.t_max); };
    std::multiset<decltype(key(CastRay{}))> ordered, shuffled;
    for (const CastRay& r : find(sets, kind).rays) ordered.insert(key(r));
    for (const CastRay& r : find(sets, kind, true).rays) shuffled.insert(key(r));
    EXPECT_EQ(ordered, shuffled) << kind;
    EXPECT_NE(key(find(sets, kind).rays.front()), key(find(sets, kind, true).rays.front())) << kind;
  }
}

TEST(BenchRays, AnEmptySceneHasOnlyPrimaryRays) {
  Scene scene = room();
  scene.instances.clear();
  const auto caster = make_reference_ray_caster(scene, place(scene));
  const auto sets = make_ray_sets(scene, *caster, {.count = 1000});
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets.front().kind, "primary");
}

class BenchCheck : public ::testing::Test {
 protected:
  BenchCheck() {
    const auto sets = make_ray_sets(scene_, *caster_, {.count = 20000});
    set_ = find(sets, "primary");
    caster_->load(set_.rays);
    caster_->cast(RayQuery::closest);
    hits_ = caster_->hits();
  }
  RayCheck check(std::size_t most = 1 << 20) { return check_rays(set_, hits_, *caster_, most); }

  Scene scene_ = room();
  std::unique_ptr<RayCaster> caster_ = make_reference_ray_caster(scene_, place(scene_));
  RaySet set_;
  std::vector<CastHit> hits_;
};

TEST_F(BenchCheck, AcceptsTheTruth) {
  const RayCheck all = check();
  EXPECT_EQ(all.checked, set_.rays.size());
  EXPECT_EQ(all.hits, set_.rays.size());
  EXPECT_EQ(all.differ, 0u);
  EXPECT_TRUE(all.passed());
  const RayCheck some = check(1000);
  EXPECT_LE(some.checked, 1000u);
  EXPECT_GT(some.checked, 900u);
}

TEST_F(BenchCheck, NoticesOneLostHit) {
  hits_[hits_.size() / 2].instance = CastHit::kNone;
  EXPECT_EQ(check().wrong, 1u);
  EXPECT_FALSE(check().passed());
}

TEST_F(BenchCheck, NoticesOneWrongDistance) {
  hits_[hits_.size() / 3].t *= 1.001f;
  EXPECT_EQ(check().wrong, 1u);
}

TEST_F(BenchCheck, ForgivesWhatRoundingExplains) {
  // A ray along the silhouette of the sphere may miss it and hit the wall: find one by bisection between a ray that
  // hits the sphere and one that does not.
  std::size_t on = 0, off = 0;
  for (std::size_t i = 0; i < hits_.size(); ++i) (hits_[i].instance == 1 ? on : off) = i;
  glm::dvec3 inside(set_.rays[on].d), outside(set_.rays[off].d);
  CastRay edge = set_.rays[on];
  CastHit wall;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 middle = glm::normalize(inside + outside);
    CastRay ray = edge;
    ray.d = glm::vec3(middle);
    caster_->load(std::span(&ray, 1));
    caster_->cast(RayQuery::closest);
    const CastHit hit = caster_->hits().front();
    if (hit.instance == 1) {
      inside = middle;
      edge = ray;
    } else {
      outside = middle;
      wall = hit;
    }
  }
  set_.rays = {edge};
  hits_ = {wall};
  const RayCheck result = check();
  EXPECT_EQ(result.differ, 1u);
  EXPECT_EQ(result.wrong, 0u);
}

class BenchExport : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }
  nlohmann::json export_json(const Scene& scene) {
    export_scene(scene, folder_.string());
    return nlohmann::json::parse(std::ifstream(folder_ / "scene.json"));
  }
  // Vertices of a PLY file with this many floats each.
  std::vector<glm::dvec3> ply_vertices(const std::string& name, std::size_t count, std::size_t floats) {
    std::ifstream file(folder_ / name, std::ios::binary);
    for (std::string line; line != "end_header";) std::getline(file, line);
    std::vector<float> data(count * floats);
    file.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size() * sizeof(float)));
    std::vector<glm::dvec3> vertices;
    for (std::size_t i = 0; i < count; ++i)
      vertices.emplace_back(data[i * floats], data[i * floats + 1], data[i * floats + 2]);
    return vertices;
  }
  std::filesystem::path folder_ = std::filesystem::path(::testing::TempDir()) / "bench-export";
};

// Where a camera sees a point: along its axes, in units of its depth.
glm::dvec2 seen(const glm::dmat4& world_from_camera, const glm::dvec3& p) {
  const glm::dvec4 local = glm::inverse(world_from_camera) * glm::dvec4(p, 1.0);
  return glm::dvec2(local.x, local.y) / local.z;
}

TEST_F(BenchExport, AMirroredCameraSeesTheSameInAMirroredScene) {
  Scene scene = room();
  scene.camera.world_from_camera =
      scene.camera.world_from_camera * glm::dmat4(glm::dmat3(-2, 0, 0, 0, 2, 0, 0, 0, 2));  // mirrors and scales
  const nlohmann::json json = export_json(scene);
  glm::dmat4 camera(1.0);
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) camera[c][r] = json["camera"]["world_from_camera"][r][c].get<double>();
  }
  EXPECT_NEAR(glm::determinant(glm::dmat3(camera)), 1.0, 1e-9);
  EXPECT_DOUBLE_EQ(json["camera"]["near"].get<double>(), 2.0 * scene.camera.near_clip);
  const auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
  const auto vertices = ply_vertices(json["shapes"][0]["mesh"]["file"], mesh.positions.size(), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const glm::dvec2 before = seen(scene.camera.world_from_camera, mesh.positions[i]),
                     after = seen(camera, vertices[i]);
    EXPECT_NEAR(glm::length(before - after), 0.0, 1e-3) << i;
  }
  const auto center = json["shapes"][1]["sphere"]["center"];
  EXPECT_DOUBLE_EQ(center[0].get<double>(), -300.3);
}

TEST_F(BenchExport, AShearingCameraIsRefused) {
  Scene scene = room();
  scene.camera.world_from_camera[0] *= 1.5;
  EXPECT_THROW(export_json(scene), Error);
}

TEST_F(BenchExport, RaysComeBackByteForByte) {
  const Scene scene = room();
  const auto caster = make_reference_ray_caster(scene, place(scene));
  const auto sets = make_ray_sets(scene, *caster, {.count = 1000});
  std::vector<std::vector<CastHit>> hits;
  for (const RaySet& set : sets) {
    caster->load(set.rays);
    caster->cast(set.query);
    hits.push_back(caster->hits());
  }
  std::filesystem::create_directories(folder_);
  const std::string path = (folder_ / "rays.bin").string();
  export_rays(scene, place(scene), sets, hits, path);
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  std::size_t at = 0;
  const auto take = [&](auto value) {
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 8), "ETDRAYS1");
  at = 8;
  EXPECT_EQ(take(std::uint64_t{}), 14u);  // the box and the lamp
  EXPECT_EQ(take(std::uint64_t{}), 1u);
  EXPECT_EQ(take(std::uint64_t{}), sets.size());
  at += 14 * 36 + 16;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    EXPECT_EQ(bytes.substr(at, sets[i].kind.size() + 1), sets[i].kind + '\0');
    at += 16;
    EXPECT_EQ(take(std::uint32_t{}), sets[i].shuffled);
    EXPECT_EQ(take(std::uint32_t{}), sets[i].query == RayQuery::any);
    EXPECT_EQ(take(std::uint64_t{}), sets[i].rays.size());
    EXPECT_EQ(std::memcmp(bytes.data() + at, sets[i].rays.data(), sets[i].rays.size() * 32), 0);
    at += sets[i].rays.size() * 32;
    for (const CastHit& hit : hits[i]) EXPECT_EQ(std::isfinite(take(float{})), hit.instance != CastHit::kNone);
  }
  EXPECT_EQ(at, bytes.size());
}

TEST(BenchReport, JsonHoldsWhatTheTableSays) {
  SceneReport scene{.name = "room", .triangles = 12, .spheres = 1};
  scene.rays.push_back({.kind = "primary", .count = 100, .hits = 99, .rate = spread_of({1e6, 2e6, 3e6})});
  scene.rays.back().check = RayCheck{.checked = 100, .differ = 1, .wrong = 1};
  BenchReport report{.device = "device", .scenes = {scene}};
  EXPECT_FALSE(report.passed());
  const nlohmann::json json = nlohmann::json::parse(bench_json(report).dump());
  EXPECT_FALSE(json["passed"]);
  EXPECT_EQ(json["scenes"][0]["rays"][0]["rays_per_second"]["median"], 2e6);
  EXPECT_EQ(json["scenes"][0]["rays"][0]["check"]["wrong"], 1);
  EXPECT_TRUE(json["scenes"][0]["samples_per_second"].is_null()) << "nothing was measured";
  const std::string table = bench_table(report);
  EXPECT_NE(table.find("2.00 (1.00 - 3.00)"), std::string::npos) << table;
  EXPECT_NE(table.find("1 are WRONG"), std::string::npos) << table;
}

}  // namespace
}  // namespace etendue
