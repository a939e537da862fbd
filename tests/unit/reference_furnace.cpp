/// Closed scenes whose radiance is known everywhere.

#include <vector>

#include <gtest/gtest.h>

#include "reference_scenes.h"

namespace etendue::reference::test {
namespace {

/// Cube of side 1 that emits 1 inward, seen from inside.
Scene cube_furnace(double albedo) {
  Scene scene;
  scene.camera.width = scene.camera.height = 8;
  scene.camera.fov = 90;
  scene.camera.world_from_camera = look_at({0, 0, 0}, {0.3, 0.2, 1}, {0, 1, 0});
  scene.integrator.max_depth = 15;
  scene.integrator.rr_depth = 0;
  add(scene, box(Vec3(-0.5), Vec3(0.5), true), diffuse(albedo), Vec3(1.0));
  return scene;
}

double geometric_series(double ratio, int terms) {
  return (1.0 - std::pow(ratio, terms)) / (1.0 - ratio);
}

TEST(ReferenceFurnace, Cube) {
  for (const double albedo : {0.5, 0.8}) {
    const double expected = geometric_series(albedo, 15);
    for (const Strategy& strategy : kStrategies) {
      Scene scene = cube_furnace(albedo);
      set_strategy(scene, strategy);
      const Estimate e = estimate(scene, 400);
      if (!strategy.nee) {
        // Every path gathers the same: no variance but the rounding to float32.
        EXPECT_NEAR(e.mean, expected, 1e-6);
        EXPECT_LT(e.standard_error, 1e-9);
        continue;
      }
      // Without MIS the variance is unbounded near the edges (second moment ~ 1/h²): a wrong answer shows, but t is
      // heavy-tailed, so that only gross errors are looked for there.
      const double limit = strategy.mis ? kMaxT : 8.0;
      EXPECT_LT(e.t(expected), limit) << strategy.name << ": " << e.mean << " ± " << e.standard_error;
      EXPECT_NEAR(e.mean, expected, 0.05 * expected) << strategy.name;
    }
  }
}

TEST(ReferenceFurnace, RouletteEndsInTheInfiniteSeries) {
  for (const double albedo : {0.5, 0.8}) {
    for (const Strategy& strategy : {kStrategies[0], kStrategies[2]}) {
      Scene scene = cube_furnace(albedo);
      scene.integrator.max_depth = Integrator::kUnlimitedDepth;
      scene.integrator.rr_depth = 2;
      set_strategy(scene, strategy);
      const Estimate e = estimate(scene, 400);
      EXPECT_LT(e.t(1.0 / (1.0 - albedo)), kMaxT) << strategy.name << ": " << e.mean << " ± " << e.standard_error;
      EXPECT_LT(e.standard_error, 0.02 * e.mean);
    }
  }
}

/// `inner` alone in a black room whose walls emit 1.
Scene in_shining_room(Body inner) {
  Scene scene;
  scene.camera.width = scene.camera.height = 4;
  scene.camera.fov = 14;
  scene.camera.world_from_camera = look_at({0.2, 0.3, -3}, {0, 0, 0}, {0, 1, 0});
  scene.integrator.max_depth = 6;
  scene.integrator.rr_depth = 0;
  add(scene, box(Vec3(-4.0), Vec3(4.0), true), diffuse(0.0), Vec3(1.0));
  add(scene, std::move(inner));
  return scene;
}

TEST(ReferenceFurnace, ShiningSphereAddsItsReflection) {
  // Convex, so it sees nothing but the room: L = Le + albedo · 1.
  for (const Strategy& strategy : kStrategies) {
    Scene scene = in_shining_room(Body{Sphere{Vec3(0.0), 1.0}, diffuse(0.7), Vec3(3.0)});
    set_strategy(scene, strategy);
    const Estimate e = estimate(scene, 4000);
    EXPECT_NEAR(e.mean, 3.7, 1e-6 + kMaxT * e.standard_error) << strategy.name;
    EXPECT_LT(e.standard_error, 0.02);
  }
}

TEST(ReferenceFurnace, ShiningSphereAlone) {
  // Nothing else to see: its own emission, and under a white sky that and the albedo.
  Scene scene = in_shining_room(Body{Sphere{Vec3(0.0), 1.0}, diffuse(0.7), Vec3(3.0)});
  scene.instances.erase(scene.instances.begin());
  EXPECT_NEAR(estimate(scene, 1000).mean, 3.0, 1e-9);
  scene.sky.top = scene.sky.horizon = Vec3(1.0);
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    if (scene.integrator.nee) {
      EXPECT_LT(estimate(scene, 50000).t(3.7), kMaxT) << strategy.name;
    } else {  // by cosine alone, every sample is the mean
      EXPECT_NEAR(estimate(scene, 1000).mean, 3.7, 1e-6);
    }
  }
}

TEST(ReferenceFurnace, SkyIsAGradientWhateverFindsIt) {
  Scene scene = floor_scene(0.5);
  scene.sky.top = Vec3(2.0);
  scene.sky.horizon = Vec3(0.5);
  // A lamp too small and dim to matter, so that there is something to choose.
  add(scene, Sphere{{0, 50, 0}, 1e-9}, diffuse(0.0), Vec3(1e-9));
  // albedo/π ∫ (h + (t − h) cos) cos dω = albedo (h + 2/3 (t − h)).
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    const Estimate e = estimate(scene, 200000);
    EXPECT_LT(e.t(0.5 * (0.5 + 2.0 / 3.0 * 1.5)), kMaxT) << strategy.name << e.mean;
  }
}

TEST(ReferenceFurnace, GlassIsInvisibleInWhite) {
  // Whatever a path does in glass that absorbs nothing, it ends at radiance 1, and η² has come and gone.
  const std::vector<Body> bodies{
      Body{Sphere{Vec3(0.0), 1.0}, DielectricBsdf{}},
      Body{Sphere{Vec3(0.0), 1.0}, DielectricBsdf{.int_ior = 1.0, .ext_ior = 1.5}},
      Body{box({-1, -1, -0.1}, {1, 1, 0.1}, false), DielectricBsdf{.int_ior = 2.0, .ext_ior = 1.0}},
  };
  for (const Body& body : bodies) {
    Scene scene = in_shining_room(body);
    scene.integrator.max_depth = 4000;  // long enough that what total reflection keeps inside is lost below 1e-3
    for (const Strategy& strategy : kStrategies) {
      set_strategy(scene, strategy);
      const Estimate exact = estimate(scene, 300);
      EXPECT_NEAR(exact.mean, 1.0, 1e-3) << strategy.name;
      scene.integrator.rr_depth = 3;
      const Estimate e = estimate(scene, 3000);
      EXPECT_NEAR(e.mean, 1.0, 1e-3 + kMaxT * e.standard_error) << strategy.name;
      scene.integrator.rr_depth = 0;
    }
  }
}

TEST(ReferenceFurnace, HollowSphereIsInvisibleInWhite) {
  Scene scene = in_shining_room(Body{Sphere{Vec3(0.0), 1.0}, DielectricBsdf{}});
  add(scene, Sphere{Vec3(0.0), 0.9}, DielectricBsdf{.int_ior = 1.000277, .ext_ior = 1.5046});
  scene.integrator.max_depth = 1000;
  const Estimate e = estimate(scene, 300);
  EXPECT_NEAR(e.mean, 1.0, 1e-6);
}

TEST(ReferenceFurnace, MirrorIsInvisibleInWhite) {
  Scene scene = in_shining_room(Body{Sphere{Vec3(0.0), 1.0}, MirrorBsdf{}});
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    EXPECT_NEAR(estimate(scene, 100).mean, 1.0, 1e-7) << strategy.name;
  }
}

TEST(ReferenceFurnace, RadianceInsideAMediumIsLargerByItsSquaredIndex) {
  // At the centre of the sphere every ray meets the surface at a right angle and leaves sooner or later.
  Scene scene;
  scene.camera = pixel_camera({0, 0, 0}, {0.1, 0.2, 1}, 120);
  add(scene, Sphere{Vec3(0.0), 1.0}, DielectricBsdf{.int_ior = 1.7, .ext_ior = 1.0});
  scene.sky.top = scene.sky.horizon = Vec3(1.0);
  scene.integrator.max_depth = 100;
  scene.integrator.rr_depth = 0;
  const Estimate exact = estimate(scene, 1000);
  EXPECT_NEAR(exact.mean, 1.7 * 1.7, 1e-6);
  EXPECT_LT(exact.standard_error, 1e-7);
  scene.integrator.rr_depth = 1;
  const Estimate roulette = estimate(scene, 100000);
  EXPECT_LT(roulette.t(1.7 * 1.7), kMaxT);
}

TEST(ReferenceFurnace, TotalReflectionKeepsLightInside) {
  // Along the diagonal of a glass cube every face is met at 54.7°, beyond the critical 41.8°.
  Scene scene;
  scene.camera = pixel_camera({0.1, 0.02, -0.05}, Vec3(0.1, 0.02, -0.05) + Vec3(1, 1, 1), 1e-6, {0, 1, 0});
  scene.camera.near_clip = 0.0;
  add(scene, box(Vec3(-1.0), Vec3(1.0), false), DielectricBsdf{.int_ior = 1.5, .ext_ior = 1.0});
  scene.sky.top = scene.sky.horizon = Vec3(1.0);
  scene.integrator.max_depth = 60;
  scene.integrator.rr_depth = 0;
  const auto vertices = make_reference_renderer(scene, {})->trace_path({0, 0});
  ASSERT_EQ(vertices.size(), 60u);
  for (std::size_t i = 0; i + 1 < vertices.size(); ++i) EXPECT_EQ(vertices[i].lobe, 2u);
  EXPECT_EQ(vertices.back().radiance, glm::vec3(0.0f));
}

}  // namespace
}  // namespace etendue::reference::test
