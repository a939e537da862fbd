/// The render kernel's build that counts, against counts that are known otherwise.

#include <cmath>

#include "device_test.h"
#include "reference_scenes.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::box;
using reference::test::diffuse;
using reference::test::quad;

class RenderCounts : public DeviceTest {
 protected:
  // A lit room with a sphere; with a tree when many small triangles lie in it.
  static Scene room(bool with_tree) {
    Scene scene;
    add(scene, box(glm::dvec3(-1.0), glm::dvec3(1.0), true), diffuse(0.6));
    add(scene, Sphere{glm::dvec3(0.3, -0.4, 0.2), 0.3}, diffuse(0.5));
    add(scene, quad(glm::dvec3(-0.3, 0.95, -0.3), glm::dvec3(0.6, 0, 0), glm::dvec3(0, 0, 0.6)), diffuse(0.5),
        glm::dvec3(5.0));
    for (int i = 0; with_tree && i < 40; ++i) {
      const glm::dvec3 at(-0.8 + 0.04 * i, -0.9 + 0.01 * i, 0.5);
      add(scene, box(at, at + 0.02, false), diffuse(0.4));
    }
    scene.camera.width = 45;  // no multiple of a tile
    scene.camera.height = 27;
    scene.camera.fov = 70.0;
    scene.camera.world_from_camera =
        reference::test::look_at(glm::dvec3(0.0, 0.0, -0.9), glm::dvec3(0.0), glm::dvec3(0, 1, 0));
    scene.integrator.max_depth = 6;
    scene.integrator.rr_depth = 3;
    return scene;
  }
};

TEST_F(RenderCounts, RaysAreTheSegmentsOfTheSamples) {
  constexpr std::uint32_t kSamples = 3;
  for (const bool with_tree : {false, true}) {
    const Scene scene = room(with_tree);
    const auto renderer = make_gpu_renderer(scene, {.seed = 7}, renderer_options());
    const RenderProfile p = gpu_profile(*renderer, kSamples);
    const std::uint32_t pixels = scene.camera.width * scene.camera.height;
    ASSERT_EQ(p.visits.size(), pixels);
    std::vector<SampleId> ids;
    for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
      for (std::uint32_t s = 0; s < kSamples; ++s) ids.push_back({pixel, s});
    }
    std::uint64_t segments = 0;
    for (const SampleRecord& record : renderer->trace_samples(ids)) segments += record.segments;
    EXPECT_EQ(p.camera.rays, std::uint64_t{pixels} * kSamples);
    EXPECT_EQ(p.camera.rays + p.scattered.rays, segments);
    EXPECT_GT(p.shadow.rays, pixels);
    double rays = 0.0, visits = 0.0;
    for (const glm::vec3& v : p.visits) {
      rays += v.z;
      visits += v.x + v.y;
    }
    EXPECT_NEAR(rays * kSamples / static_cast<double>(p.camera.rays + p.scattered.rays + p.shadow.rays), 1.0, 1e-6);
    for (const RayCounts& c : {p.camera, p.scattered, p.shadow}) {
      if (with_tree) {
        EXPECT_GT(c.nodes, 0u);
        EXPECT_GT(c.nodes + c.primitives, c.rays);
        EXPECT_LT(c.nodes + c.primitives, 100 * c.rays);
      } else {  // every ray meets all primitives: 12 + 2 triangles and a sphere
        EXPECT_EQ(c.nodes, 0u);
        EXPECT_EQ(c.primitives, 15 * c.rays);
      }
    }
    EXPECT_GT(visits, 0.0);
  }
}

TEST_F(RenderCounts, TheSameWhereverTablesAreRead) {
  GpuOptions texels = renderer_options(), storage = renderer_options();
  texels.loads = TableLoads::texel_buffer;
  storage.loads = TableLoads::storage_buffer;
  const RenderProfile a = gpu_profile(*make_gpu_renderer(room(true), {}, texels), 2);
  const RenderProfile b = gpu_profile(*make_gpu_renderer(room(true), {}, storage), 2);
  EXPECT_EQ(a.visits, b.visits);
  EXPECT_EQ(a.shadow.nodes, b.shadow.nodes);
}

TEST_F(RenderCounts, LanesAtWorkAreAFraction) {
  const auto renderer = make_gpu_renderer(room(true), {}, renderer_options());
  const RenderProfile p = gpu_profile(*renderer, 4);
  if (!p.walk_utilisation) GTEST_SKIP() << "the device has no subgroup ballots";
  for (const double utilisation : {*p.walk_utilisation, *p.shade_utilisation}) {
    EXPECT_GT(utilisation, 0.1);
    EXPECT_LE(utilisation, 1.0 + 1e-3);
  }
}

TEST_F(RenderCounts, CameraRaysAloneKeepAllLanesBusyInAPictureOfWholeTiles) {
  // One primitive test a ray and one segment a path: lanes never part.
  Scene scene = room(false);
  scene.camera.width = 64;
  scene.camera.height = 32;
  scene.integrator.max_depth = 1;
  const auto renderer = make_gpu_renderer(scene, {}, renderer_options());
  const RenderProfile p = gpu_profile(*renderer, 4);
  EXPECT_EQ(p.scattered.rays, 0u);
  EXPECT_EQ(p.shadow.rays, 0u);
  if (p.walk_utilisation) {
    EXPECT_NEAR(*p.walk_utilisation, 1.0, 1e-3);
    EXPECT_NEAR(*p.shade_utilisation, 1.0, 1e-3);
  }
}

}  // namespace
}  // namespace etendue::test
