/// The driver's walk through acceleration structures against our tree, on devices that have ray queries: the same hits,
/// the same films, closed surfaces as tight. The tests that need such a device are run on every driver that has one
/// (tests/drivers).

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "core/errors.h"
#include "device_test.h"
#include "formats/read_scene.h"
#include "gpu/ray_caster.h"
#include "instanced_scenes.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::box;
using reference::test::diffuse;
using reference::test::quad;

class RayQueries : public DeviceTest {
 protected:
  static GpuOptions options(Traversal traversal) {
    GpuOptions out = renderer_options();
    out.traversal = traversal;
    return out;
  }
  struct Answers {
    std::vector<CastHit> closest, any;
  };
  static Answers cast(const Scene& scene, std::span<const CastRay> rays, Traversal traversal) {
    const auto caster = make_gpu_ray_caster(scene, options(traversal));
    caster->load(rays);
    caster->cast(RayQuery::closest);
    Answers out{.closest = caster->hits(), .any = {}};
    caster->cast(RayQuery::any);
    out.any = caster->hits();
    return out;
  }
  // To the bit where kernels with the same formulas compute the same; elsewhere but for rays that pass an edge within
  // rounding. `tolerance`: of distances, 0 for equal bits.
  static void expect_same_hits(const std::string& what, const Scene& scene, std::span<const CastRay> rays,
                               float tolerance = 0.0f) {
    if (!is_lavapipe()) tolerance = std::max(tolerance, 1e-5f);
    const Answers tree = cast(scene, rays, Traversal::tree), query = cast(scene, rays, Traversal::query);
    std::size_t differ = 0, hits = 0;
    std::string last;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const CastHit &a = tree.closest[i], &b = query.closest[i];
      const bool hit = a.instance != CastHit::kNone;
      hits += hit;
      const bool same = a.instance == b.instance &&
                        (!hit || (a.primitive == b.primitive && std::abs(a.t - b.t) <= tolerance * (1.0f + a.t)));
      const bool same_any = (tree.any[i].instance == CastHit::kNone) == (query.any[i].instance == CastHit::kNone);
      if (same && same_any) continue;
      ++differ;
      last = fmt::format("; ray {}: the tree finds {}:{} at {}, the driver {}:{} at {}", i, a.instance, a.primitive,
                         a.t, b.instance, b.primitive, b.t);
    }
    EXPECT_LE(differ, tolerance == 0.0f ? 0u : rays.size() / 5000) << what << last;
    EXPECT_GT(hits, rays.size() / 20) << what << ": the test hardly tests";
  }
  // Rays from within and from around the scene, some along the axes, some short, some that begin late.
  static std::vector<CastRay> mixed_rays(std::size_t count, std::uint64_t seed, float around = 3.0f) {
    Random random(seed);
    std::vector<CastRay> rays;
    for (std::size_t i = 0; i < count; ++i) {
      CastRay ray{.o = random.point(i % 2 == 0 ? 1.0f : around), .d = glm::vec3(random.direction()), .t_max = INFINITY};
      if (i % 2 == 1) ray.d = glm::vec3(glm::normalize(glm::dvec3(random.point(0.8f)) - glm::dvec3(ray.o)));
      if (i % 7 == 0) {
        ray.d = glm::vec3(0.0f);
        ray.d[static_cast<int>(random.below(3))] = random.unit() < 0.5f ? -1.0f : 1.0f;
      }
      if (i % 3 == 0) ray.t_max = 2.0f * random.unit();
      if (i % 11 == 0) ray.t_min = 0.5f * random.unit();
      rays.push_back(ray);
    }
    return rays;
  }
  static TriangleMesh soup(std::size_t count, float size, std::uint64_t seed) {
    Random random(seed);
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
      const glm::dvec3 at(random.point(1.0f));
      for (int k = 0; k < 3; ++k) mesh.positions.push_back(at + double{size} * glm::dvec3(random.point(1.0f)));
      mesh.triangles.push_back(glm::uvec3(0, 1, 2) + 3 * i);
    }
    return mesh;
  }

  void SetUp() override {
    DeviceTest::SetUp();
    if (IsSkipped()) return;
    bool has = false;
    for (const vulkan::DeviceInfo& info : vulkan::list_devices(renderer_options().context)) has |= info.ray_queries;
    if (!has) GTEST_SKIP() << "no device has ray queries";
  }
};

TEST_F(RayQueries, HitsAreThoseOfTheTree) {
  for (const auto& [count, size] : {std::pair{40, 0.5f}, {3000, 0.1f}, {30000, 0.03f}}) {
    Scene scene;
    add(scene, soup(count, size, count), diffuse(0.5));
    expect_same_hits(fmt::format("{} triangles", count), scene, mixed_rays(30000, count));
  }
}

TEST_F(RayQueries, RoundShapesToo) {
  Random random(5);
  Scene scene;
  for (int i = 0; i < 40; ++i) {
    add(scene, Sphere{glm::dvec3(random.point(1.0f)), 0.05 + 0.1 * random.unit()}, diffuse(0.5));
    add(scene, Cylinder{glm::dvec3(random.point(1.0f)), glm::dvec3(random.point(1.0f)), 0.01 + 0.1 * random.unit()},
        diffuse(0.5));
    add(scene, Disk{}, diffuse(0.5)).world_from_object =
        glm::translate(glm::dmat4(1.0), glm::dvec3(random.point(1.0f))) *
        glm::rotate(glm::dmat4(1.0), 6.0 * random.unit(), random.direction()) *
        glm::scale(glm::dmat4(1.0), glm::dvec3(0.1, 0.3, 1.0));
  }
  add(scene, soup(500, 0.2f, 6), diffuse(0.5));
  expect_same_hits("spheres, disks, cylinders and triangles", scene, mixed_rays(30000, 7));
}

TEST_F(RayQueries, SharedMeshesToo) {
  for (const std::uint64_t seed : {1, 2}) {
    const Scene scene = instanced_room(seed, Instancing::always);
    ASSERT_TRUE(Sharing(scene).any());
    expect_same_hits("instances", scene, mixed_rays(30000, seed));
  }
  // Small, far from the centre, mirrored, and squeezed to a hundredth along one axis: the driver's own inverse of such
  // a matrix is a poor one.
  Random random(9);
  Scene scene;
  scene.instancing = Instancing::always;
  const std::uint32_t shape = [&] {
    add(scene, bumpy_ball(20), diffuse(0.5));
    return static_cast<std::uint32_t>(scene.shapes.size() - 1);
  }();
  scene.instances.front().world_from_object = glm::translate(glm::dmat4(1.0), glm::dvec3(1.0));
  for (int i = 0; i < 200; ++i) {
    Instance instance = scene.instances.front();
    instance.shape = shape;
    instance.world_from_object =
        glm::translate(glm::dmat4(1.0), glm::dvec3(random.point(1.0f))) *
        glm::rotate(glm::dmat4(1.0), 6.0 * random.unit(), random.direction()) *
        glm::scale(glm::dmat4(1.0), glm::dvec3(i % 2 == 0 ? 0.3 : -0.01, 0.1, i % 3 == 0 ? 0.001 : 0.2));
    scene.instances.push_back(instance);
  }
  ASSERT_TRUE(Sharing(scene).any());
  expect_same_hits("small and flat instances", scene, mixed_rays(30000, 10));
}

// Two grids in one plane: everything is met twice at about, and often at exactly, the same distance.
TEST_F(RayQueries, TiesAreDecidedAlike) {
  Scene scene;
  for (const int cells : {7, 11}) {
    for (int i = 0; i < cells * cells; ++i) {
      const double x = -1.0 + 2.0 * (i % cells) / cells, z = -1.0 + 2.0 * (i / cells) / cells;
      add(scene, quad({x, 0.25, z}, {0, 0, 2.0 / cells}, {2.0 / cells, 0, 0}), diffuse(0.5));
    }
  }
  std::vector<CastRay> rays;
  Random random(3);
  for (int i = 0; i < 30000; ++i) {
    const glm::vec3 o = random.point(0.9f) + glm::vec3(0, 2, 0);
    rays.push_back({.o = o,
                    .d = i % 2 == 0 ? glm::vec3(0, -1, 0)
                                    : glm::vec3(glm::normalize(glm::dvec3(random.point(0.9f)) - glm::dvec3(o))),
                    .t_max = INFINITY});
  }
  expect_same_hits("coplanar grids", scene, rays);
}

// From there a query begins nearer to the scene, so distances may differ by rounding.
TEST_F(RayQueries, RaysFromFarAway) {
  Scene scene;
  add(scene, soup(3000, 0.1f, 4), diffuse(0.5));
  for (const float far : {20.0f, 300.0f, 10000.0f}) {
    Random random(static_cast<std::uint64_t>(far));
    std::vector<CastRay> rays;
    for (int i = 0; i < 20000; ++i) {
      const glm::dvec3 o = double{far} * random.direction();
      rays.push_back(
          {.o = glm::vec3(o), .d = glm::vec3(glm::normalize(glm::dvec3(random.point(0.7f)) - o)), .t_max = INFINITY});
    }
    // The tree's own distances are worth that much from there.
    const float rounding = far * 1e-6f;
    const Answers tree = cast(scene, rays, Traversal::tree), query = cast(scene, rays, Traversal::query);
    std::size_t differ = 0, hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const CastHit &a = tree.closest[i], &b = query.closest[i];
      const bool hit = a.instance != CastHit::kNone;
      hits += hit;
      differ += a.instance != b.instance || (hit && (a.primitive != b.primitive || std::abs(a.t - b.t) > rounding));
    }
    EXPECT_GT(hits, rays.size() / 4);
    // The share of rays that pass an edge within the rounding of a coordinate `far` away.
    EXPECT_LE(static_cast<double>(differ), 10.0 + 100.0 * rounding * static_cast<double>(rays.size())) << far;
  }
}

// Rays at vertices and at points of edges, from inside; the mesh lies in the world, and is shared.
TEST_F(RayQueries, ClosedSurfacesDoNotLeak) {
  const TriangleMesh ball = bumpy_ball(40, false);
  for (const bool shared : {false, true}) {
    Scene scene;
    scene.instancing = shared ? Instancing::always : Instancing::never;
    add(scene, ball, diffuse(0.5)).world_from_object = glm::translate(glm::dmat4(1.0), glm::dvec3(0.31, -0.2, 0.17));
    add(scene, quad({-3, -3, -3}, {1, 0, 0}, {0, 1, 0}), diffuse(0.5));
    if (shared) {
      Instance second = scene.instances.front();
      second.world_from_object =
          glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(2.5, 0.1, 0.0)), glm::dvec3(0.05, 0.09, 0.07));
      scene.instances.push_back(second);
    }
    const auto caster = make_gpu_ray_caster(scene, options(Traversal::query));
    const Placement at = caster->placement();
    Random random(21);
    std::vector<CastRay> rays;
    for (std::size_t i = 0; i < 200000; ++i) {
      const Instance& within = scene.instances[shared && i % 3 == 0 ? 2 : 0];
      const glm::uvec3& t = ball.triangles[random.below(static_cast<std::uint32_t>(ball.triangles.size()))];
      const double along = i % 2 == 0 ? 0.0 : double{random.unit()};
      const glm::dvec3 aim = glm::mix(ball.positions[t.x], ball.positions[t.y], along);
      const auto place = [&](const glm::dvec3& p) {
        return (glm::dvec3(within.world_from_object * glm::dvec4(p, 1.0)) - at.center) * at.scale;
      };
      const glm::vec3 o(place(glm::dvec3(random.point(0.3f))));
      rays.push_back({.o = o, .d = glm::vec3(glm::normalize(place(aim) - glm::dvec3(o))), .t_max = INFINITY});
    }
    caster->load(rays);
    for (const RayQuery kind : {RayQuery::closest, RayQuery::any}) {
      caster->cast(kind);
      std::size_t leaks = 0;
      for (std::size_t i = 0; const CastHit& hit : caster->hits()) {
        const std::uint32_t within = shared && i++ % 3 == 0 ? 2 : 0;
        leaks += kind == RayQuery::any ? hit.instance == CastHit::kNone : hit.instance != within;
      }
      EXPECT_EQ(leaks, 0u) << (shared ? "shared" : "in the world");
    }
  }
}

struct SceneAt {
  const char* file;
  std::uint32_t samples;
};

// The picture, sample by sample: decisions are the same, and so is the film where kernels compute alike.
TEST_F(RayQueries, PicturesAreThoseOfTheTree) {
  for (const auto& [file, samples] :
       {SceneAt{SCENES_DIR "/cbox-sphere.xml", 4}, SceneAt{SCENES_DIR "/forest.xml", 1},
        SceneAt{SCENES_DIR "/cbox-bumpy.xml", 2}, SceneAt{TEST_DIR "/../scenes/mesh_cylinder.xml", 2},
        SceneAt{TEST_DIR "/../scenes/adapter_mask.xml", 2}}) {
    SceneFile read = read_scene_file(file, {});
    Scene scene = std::holds_alternative<TTest>(read) ? std::get<TTest>(read).scenes.front() : std::get<Scene>(read);
    scene.camera.width = 61;
    scene.camera.height = 43;
    std::vector<Film> films;
    for (const Traversal traversal : {Traversal::tree, Traversal::query}) {
      const auto renderer = make_gpu_renderer(scene, {.seed = 3}, options(traversal));
      films.emplace_back(61, 43, film_exponent(scene));
      std::vector<RejectedSample> rejected;
      renderer->render({0, samples}, films.back(), {}, rejected);
    }
    std::size_t different = 0;
    for (std::size_t i = 0; i < films[0].pixels().size(); ++i)
      different += !(films[0].pixels()[i] == films[1].pixels()[i]);
    // Elsewhere a pixel in a hundred may hold a path that rounding sent on another way.
    EXPECT_LE(different, is_lavapipe() ? 0u : films[0].pixels().size() / 100) << file;
  }
}

TEST_F(RayQueries, CountsAreOfTheTreeOnly) {
  const auto renderer = make_gpu_renderer(instanced_room(1, Instancing::always), {}, options(Traversal::query));
  EXPECT_THROW(gpu_profile(*renderer, 1), Error);
}

class RayQueriesRefused : public DeviceTest {};

// On a device without them by name of what lacks; on any where it was opened without.
TEST_F(RayQueriesRefused, InASentence) {
  GpuOptions options = renderer_options();
  options.traversal = Traversal::query;
  const auto refusal = [&] {
    try {
      make_gpu_renderer(instanced_room(1, Instancing::always), {}, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::device);
      return std::string(error.what());
    }
    return std::string();
  };
  bool has = false;
  for (const vulkan::DeviceInfo& info : vulkan::list_devices(options.context)) has |= info.ray_queries;
  const std::string said = refusal();
  EXPECT_EQ(said.empty(), has) << said;
  if (!has) {
    EXPECT_NE(said.find("it lacks the "), std::string::npos) << said;
    EXPECT_NE(said.find("which '--traversal query' needs; '--traversal tree' does without"), std::string::npos) << said;
  }
  options.open = std::make_shared<const vulkan::Context>("auto", options.context);
  EXPECT_NE(refusal().find("was not opened for ray queries"), std::string::npos);
}

}  // namespace
}  // namespace etendue::test
