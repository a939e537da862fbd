// What a few paths find out about a scene: each warning where it belongs, none where it does not.

#include "validate/scene_probe.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

namespace etendue {
namespace {

using testing::HasSubstr;
using testing::Not;

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
  EXPECT_THAT(probe(clipped), HasSubstr("clipping planes"));
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

/// `count` triangles one behind the other, the first nearest to the camera.
TriangleMesh stack(std::uint32_t count, double step, double size = 1.0) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double z = 5.0 + step * i;
    for (const glm::dvec3& p : {glm::dvec3(-size, -size, z), glm::dvec3(0, size, z), glm::dvec3(size, -size, z)})
      mesh.positions.push_back(p);
    mesh.triangles.push_back(glm::uvec3(0, 1, 2) + 3 * i);
  }
  return mesh;
}

TEST(Probe, TwinsAreNoCrowd) {
  Scene scene = scene_of({lamp({0, 4, 2}, 0.5)});
  scene.add(stack(200000, 0.0, 4.0));
  EXPECT_EQ(probe(scene), "");
}

TEST(Probe, WhatNoTreeCanPartIsRefused) {
  const auto errors = [](Scene scene) {
    Diagnostics diagnostics;
    probe_scene(std::move(scene), diagnostics);
    return diagnostics.error_count();
  };
  // One behind the other: a ray beside the triangles and within their boxes passes them all.
  Scene deep = scene_of({lamp({0, 4, 2}, 0.5)}), slow = deep;
  deep.add(stack(30000, 1e-6));
  EXPECT_THAT(probe(deep), HasSubstr("meets the boxes of 30000 triangles or spheres before it hits one"));
  EXPECT_EQ(errors(deep), 1u);
  slow.add(stack(10000, 1e-6));
  EXPECT_THAT(probe(slow), HasSubstr("no paths were tried"));
  EXPECT_EQ(errors(slow), 0u);
  // What hides behind a wall costs the camera's rays nothing.
  TriangleMesh wall{.positions = {{-20, -20, 4}, {-20, 20, 4}, {20, -20, 4}, {20, 20, 4}},
                    .triangles = {{0, 1, 2}, {2, 1, 3}}};
  Scene hidden = deep;
  hidden.add(wall);
  EXPECT_THAT(probe(hidden), Not(HasSubstr("meets the boxes")));
  // All around one point.
  std::vector<Ball> onion;
  for (int i = 0; i < 12000; ++i) onion.push_back(ball({0, 0, 5}, 1.0 + 1e-5 * i));
  EXPECT_THAT(probe(scene_of(onion)), HasSubstr("12000 triangles or spheres overlap at 0 0 5, \"ball\" among them"));
  EXPECT_EQ(errors(scene_of(onion)), 1u);
}

}  // namespace
}  // namespace etendue
