/// Closed scenes whose radiance is known everywhere.

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
  scene.shapes.push_back(shape(box(Vec3(-0.5), Vec3(0.5), true), diffuse(albedo), Vec3(1.0)));
  return scene;
}

double geometric_series(double ratio, int terms) { return (1.0 - std::pow(ratio, terms)) / (1.0 - ratio); }

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

}  // namespace
}  // namespace etendue::reference::test
