// What a few paths find out about a scene: each warning where it belongs, none where it does not.

#include "validate/scene_probe.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace etendue {
namespace {

using testing::HasSubstr;

/// A sphere to be added to a scene.
struct Ball {
  Sphere sphere;
  Bsdf bsdf;
  std::optional<AreaEmitter> emitter;
  const char* name;
};
Ball ball(const glm::dvec3& center, double radius, const Bsdf& bsdf = DiffuseBsdf{}) {
  return {{center, radius}, bsdf, std::nullopt, "ball"};
}
Ball lamp(const glm::dvec3& center, double radius) {
  return {{center, radius}, DiffuseBsdf{}, AreaEmitter{glm::dvec3(5.0)}, "lamp"};
}

/// The camera stands in the origin and looks along +Z.
Scene scene_of(const std::vector<Ball>& balls) {
  Scene scene;
  for (const Ball& b : balls) scene.add(b.sphere, b.bsdf, b.emitter).name = b.name;
  return scene;
}

std::string probe(Scene scene) {
  Diagnostics diagnostics;
  probe_scene(std::move(scene), diagnostics);
  std::string text;
  for (const Diagnostic& d : diagnostics.list()) text += d.message + "\n";
  return text;
}

TEST(Probe, ASoundSceneIsQuiet) {
  EXPECT_EQ(probe(scene_of({ball({0, 0, 5}, 1.0), lamp({0, 4, 2}, 0.5)})), "");
  Scene sky = scene_of({ball({0, 0, 5}, 1.0)});
  sky.sky.top = glm::dvec3(1.0);
  EXPECT_EQ(probe(sky), "");
}

TEST(Probe, ACameraThatSeesNothing) {
  EXPECT_THAT(probe(scene_of({ball({0, 0, -5}, 1.0), lamp({0, 4, -2}, 0.5)})),
              HasSubstr("none of 2304 camera rays meets a mesh"));
  Scene clipped = scene_of({lamp({0, 0, 5}, 1.0)});
  clipped.camera.far_clip = 3.0;
  EXPECT_THAT(probe(clipped), HasSubstr("nearClip and farClip"));
  EXPECT_THAT(probe(scene_of({})), HasSubstr("no mesh"));
}

TEST(Probe, LightThatNeverArrives) {
  // The lamp hangs inside a ball: all is black.
  EXPECT_THAT(probe(scene_of({ball({0, 0, 8}, 1.0), ball({0, 4, 2}, 1.0), lamp({0, 4, 2}, 0.5)})),
              HasSubstr("none of 2304 paths finds light"));
  // With a second lamp in the open, the first is still never reached.
  const std::string found =
      probe(scene_of({ball({0, 0, 8}, 1.5), ball({0, 4, 2}, 1.0), lamp({0, 4, 2}, 0.5), lamp({3, 0, 2}, 0.5)}));
  EXPECT_THAT(found, HasSubstr("the emitter \"lamp\" was tried"));
  EXPECT_EQ(std::count(found.begin(), found.end(), '\n'), 1);
}

TEST(Probe, ALampThatIsOnlySeenOrLiesBehindGlass) {
  EXPECT_EQ(probe(scene_of({lamp({0, 0, 5}, 1.0)})), "");
  EXPECT_EQ(probe(scene_of({lamp({0, 0, 5}, 0.9), ball({0, 0, 5}, 1.0, DielectricBsdf{})})), "");
}

TEST(Probe, PathsWithoutEndEnd) {
  Scene box = scene_of({ball({0, 0, 0}, 10.0, DielectricBsdf{1.0, 900.0})});
  box.integrator.max_depth = Integrator::kUnlimitedDepth;
  box.integrator.rr_depth = 0;
  box.sky.top = glm::dvec3(1.0);
  probe(box);
}

}  // namespace
}  // namespace etendue
