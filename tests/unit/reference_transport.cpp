/// Light that travels through mirrors, glass and several bounces: closed forms, and strategies against each other.

#include <gtest/gtest.h>

#include "reference/fresnel.h"
#include "reference_scenes.h"

namespace etendue::reference::test {
namespace {

double two_sample_t(const Estimate& a, const Estimate& b) {
  return std::abs(a.mean - b.mean) / std::hypot(a.standard_error, b.standard_error);
}

TEST(ReferenceTransport, WindowTransmitsAndReflectsAllOrders) {
  // A pane between a shining wall and darkness, looked at straight: T = (1 − F)/(1 + F), R = 2F/(1 + F).
  for (const double n : {1.33, 1.5046, 2.4}) {
    for (const bool behind : {true, false}) {
      Scene scene;
      scene.camera = pixel_camera({0, 0, -2}, {0, 0, 0}, 1e-6, {0, 1, 0});
      scene.integrator.max_depth = 200;
      scene.integrator.rr_depth = 0;
      add(scene, box({-1, -1, -0.1}, {1, 1, 0.1}, false), DielectricBsdf{.int_ior = n, .ext_ior = 1.0});
      add(scene, behind ? quad({-9, -9, 3}, {0, 18, 0}, {18, 0, 0}) : quad({-9, -9, -3}, {18, 0, 0}, {0, 18, 0}),
          diffuse(0.0), Vec3(1.0));
      const double f = fresnel_dielectric(1.0, 1.0, n).reflectance;
      const double expected = behind ? (1 - f) / (1 + f) : 2 * f / (1 + f);
      for (const Strategy& strategy : kStrategies) {
        set_strategy(scene, strategy);
        const Estimate e = estimate(scene, 100000);
        EXPECT_LT(e.t(expected), kMaxT) << n << (behind ? " T " : " R ") << strategy.name << ": " << e.mean;
      }
    }
  }
}

TEST(ReferenceTransport, MirrorsShowEmittersInFullAndTheirBacksBlack) {
  Scene scene;
  scene.camera = pixel_camera({0, 1, 0}, {1, 0, 0}, 1e-6, {0, 0, 1});
  add(scene, quad({-10, 0, -10}, {0, 0, 20}, {20, 0, 0}), MirrorBsdf{});
  add(scene, quad({3, -5, -5}, {0, 0, 10}, {0, 10, 0}), MirrorBsdf{});              // normal −x
  add(scene, quad({-3, -5, -5}, {0, 20, 0}, {0, 0, 10}), diffuse(0.0), Vec3(2.5));  // shines to +x
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    EXPECT_NEAR(estimate(scene, 100).mean, 2.5, 1e-6) << strategy.name;
    Scene turned = scene;  // the second mirror from behind is black, and so is the emitter's back
    std::swap(std::get<TriangleMesh>(turned.shapes[1]).triangles[0].x,
              std::get<TriangleMesh>(turned.shapes[1]).triangles[0].y);
    std::swap(std::get<TriangleMesh>(turned.shapes[1]).triangles[1].x,
              std::get<TriangleMesh>(turned.shapes[1]).triangles[1].y);
    EXPECT_EQ(estimate(turned, 100).mean, 0.0) << strategy.name;
  }
}

TEST(ReferenceTransport, ALampInItsOwnLightIsOneSided) {
  Scene scene = floor_scene();
  add(scene, quad({-1, 1, -1}, {0, 0, 2}, {2, 0, 0}), diffuse(0.0), Vec3(1.0));  // shines upward
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    EXPECT_EQ(estimate(scene, 10000).mean, 0.0) << strategy.name;
  }
}

TEST(ReferenceTransport, AnOccluderHidesWhatItCovers) {
  // A screen over the half-space x < 0 leaves exactly half of a symmetric lamp's light.
  Scene scene = floor_scene();
  const TriangleMesh lamp = quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
  add(scene, lamp, diffuse(0.0), Vec3(1.0));
  add(scene, quad({-5, 0.5, -5}, {5, 0, 0}, {0, 0, 10}), diffuse(0.0));
  const double expected = 0.25 / kPi * polygon_irradiance({lamp.positions.begin(), lamp.positions.end()}, {0, 1, 0});
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    const Estimate e = estimate(scene, 200000);
    EXPECT_LT(e.t(expected), kMaxT) << strategy.name << ": " << e.mean << ", expected " << expected;
  }
}

/// A room with everything in it: coloured walls, two lamps, mirror, glass, a lamp behind glass, smooth normals.
Scene busy_room() {
  Scene scene;
  scene.camera.width = 12, scene.camera.height = 9, scene.camera.fov = 60;
  scene.camera.world_from_camera = look_at({0, 0, -0.95}, {0, -0.1, 0.2}, {0, 1, 0});
  scene.integrator.max_depth = 7;
  scene.integrator.rr_depth = 0;
  add(scene, box(Vec3(-1.0), Vec3(1.0), true), DiffuseBsdf{.albedo = {0.7, 0.5, 0.4}});
  add(scene, quad({-0.4, 0.9, -0.4}, {0.8, 0, 0}, {0, 0, 0.8}), diffuse(0.5), Vec3(4, 5, 6));
  add(scene, Sphere{{0.6, -0.5, 0.5}, 0.25}, diffuse(0.1), Vec3(3, 2, 1));
  add(scene, Sphere{{0.6, -0.5, 0.5}, 0.35}, DielectricBsdf{});  // around that lamp
  add(scene, Sphere{{-0.5, -0.5, 0.4}, 0.35}, MirrorBsdf{});
  TriangleMesh tent = triangle({-0.3, -0.9, -0.2}, {0.0, -0.9, 0.4}, {0.3, -0.9, -0.2});
  tent.normals = {glm::normalize(Vec3(-0.4, 1, -0.3)), glm::normalize(Vec3(0, 1, 0.5)),
                  glm::normalize(Vec3(0.4, 1, -0.3))};
  add(scene, tent, diffuse(0.8));
  return scene;
}

TEST(ReferenceTransport, AllStrategiesAgreeThroughGlassAndMirrors) {
  Scene scene = busy_room();
  std::vector<Estimate> estimates;
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    estimates.push_back(estimate(scene, 3000, 31));
    EXPECT_LT(estimates.back().standard_error, 0.01 * estimates.back().mean) << strategy.name;
  }
  EXPECT_LT(two_sample_t(estimates[0], estimates[1]), kMaxT) << estimates[0].mean << ' ' << estimates[1].mean;
  EXPECT_LT(two_sample_t(estimates[0], estimates[2]), kMaxT) << estimates[0].mean << ' ' << estimates[2].mean;
}

TEST(ReferenceTransport, RouletteChangesNoMean) {
  Scene scene = busy_room();
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    scene.integrator.rr_depth = 0;
    const Estimate off = estimate(scene, 2000, 1);
    for (const std::uint32_t depth : {1u, 3u}) {
      scene.integrator.rr_depth = depth;
      const Estimate on = estimate(scene, 2000, 2);
      EXPECT_LT(two_sample_t(off, on), kMaxT) << strategy.name << " rrDepth " << depth;
    }
  }
}

TEST(ReferenceTransport, DepthCountsSegments) {
  // One path segment sees emission, two direct light; every further one adds to a room that reflects.
  Scene scene = busy_room();
  double before = -1.0;
  for (const std::uint32_t depth : {1u, 2u, 3u, 5u}) {
    scene.integrator.max_depth = depth;
    const double mean = estimate(scene, 300).mean;
    EXPECT_GT(mean, before) << depth;
    before = mean;
    const auto records = make_reference_renderer(scene, {})->trace_samples(std::vector<SampleId>{{50, 0}, {20, 1}});
    for (const SampleRecord& record : records) EXPECT_LE(record.segments, depth);
  }
}

TEST(ReferenceTransport, TheShadingNormalAloneDecidesTheSide) {
  // Normals tilted so far that part of their hemisphere lies under the surface: light from there counts, too, by
  // whatever strategy it is found, and all directions together are no more than the albedo.
  Scene scene = floor_scene(1.0);
  auto& floor = std::get<TriangleMesh>(scene.shapes[0]);
  floor.normals = std::vector<glm::dvec3>(floor.positions.size(), glm::normalize(Vec3(1.0, 0.5, 0.0)));
  // Below the floor everything shines, above nothing does.
  add(scene, quad({-10, -1, -10}, {0, 0, 20}, {20, 0, 0}), diffuse(0.0), Vec3(1.0));
  std::vector<Estimate> estimates;
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    estimates.push_back(estimate(scene, 20000));
    EXPECT_GT(estimates.back().mean, 0.2) << strategy.name;
    EXPECT_LT(two_sample_t(estimates.front(), estimates.back()), kMaxT) << strategy.name;
  }
  // Light all around: ∫ max(0, ns·w)/π dw = 1, whatever the tilt.
  scene.instances.pop_back();
  scene.sky.top = scene.sky.horizon = Vec3(1.0);
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    if (scene.integrator.nee) {
      EXPECT_LT(estimate(scene, 50000).t(1.0), kMaxT) << strategy.name;
    } else {
      EXPECT_NEAR(estimate(scene, 1000).mean, 1.0, 1e-12);
    }
  }
}

TEST(ReferenceTransport, ABlackSideEndsThePathBeforeAnyLightIsSampled) {
  Scene scene = floor_scene();
  add(scene, Sphere{{0, -1, 0}, 0.2}, diffuse(0.0), Vec3(1.0));
  scene.camera = pixel_camera({0, -0.01, 0}, {0, 0, 0});  // the floor from below
  const auto path = make_reference_renderer(scene, {})->trace_path({0, 0});
  ASSERT_EQ(path.size(), 1u);
  EXPECT_EQ(path[0].instance, 0u);
  EXPECT_EQ(path[0].light_instance, PathVertex::kNone);
  EXPECT_EQ(path[0].lobe, 0u);
  EXPECT_EQ(path[0].radiance, glm::vec3(0.0f));
}

TEST(ReferenceTransport, SkyIsItsHorizonBelowIt) {
  Scene scene;
  scene.sky.top = Vec3(3.0);
  scene.sky.horizon = Vec3(1.0);
  for (const auto& [y, expected] :
       {std::pair(-0.8, 1.0), std::pair(0.0, 1.0), std::pair(0.5, 2.0), std::pair(1.0, 3.0)}) {
    scene.camera = pixel_camera(Vec3(0.0), {std::sqrt(1 - y * y), y, 0});
    EXPECT_NEAR(estimate(scene, 10).mean, expected, 1e-6) << y;
  }
}

TEST(ReferenceTransport, NormalsIntegrator) {
  Scene scene = floor_scene();
  scene.integrator.type = Integrator::Type::normals;
  const auto renderer = make_reference_renderer(scene, {});
  const auto record = renderer->trace_samples(std::vector<SampleId>{{0, 0}})[0];
  EXPECT_EQ(record.radiance, glm::vec3(0.5f, 1.0f, 0.5f));
  EXPECT_EQ(record.segments, 1u);
  scene.instances.clear();
  EXPECT_EQ(make_reference_renderer(scene, {})->trace_samples(std::vector<SampleId>{{0, 0}})[0].radiance,
            glm::vec3(0.0f));
}

TEST(ReferenceTransport, ClippingPlanesCutAlongTheCameraAxis) {
  Scene scene = floor_scene();
  scene.integrator.type = Integrator::Type::normals;
  scene.camera.far_clip = 0.0099;
  EXPECT_EQ(estimate(scene, 10).mean, 0.0);
  scene.camera.far_clip = 0.0101;
  EXPECT_GT(estimate(scene, 10).mean, 0.5);
  scene.camera.near_clip = 0.01005;
  EXPECT_EQ(estimate(scene, 10).mean, 0.0);
}

}  // namespace
}  // namespace etendue::reference::test
