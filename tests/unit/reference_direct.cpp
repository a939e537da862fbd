/// Direct light on a diffuse floor: closed forms for any number of polygons and spheres.

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "reference_scenes.h"

namespace etendue::reference::test {
namespace {

struct DirectCase {
  std::array<Vec3, 3> vertices;
  double reference;
};
const std::array<DirectCase, 5> kDirect{{
    {{{{-0.443432, 0.596366, 0.495985}, {-0.320397, 0.0677699, -0.229359}, {0.0341197, 0.11415, -0.343049}}},
     0.0898394},
    {{{{0.461963, 0.397843, 0.412747}, {-0.0381582, 0.851323, -0.156872}, {0.195443, 0.891957, -0.260672}}}, 0.02292},
    {{{{0.100871, 0.289075, -0.422609}, {-0.308386, 0.629587, 0.423966}, {-0.373132, 0.237287, 0.351592}}}, 0.0534198},
    {{{{-0.17575, 0.639397, 0.151268}, {0.318604, 0.732996, 0.459771}, {0.139095, 0.294498, 0.478556}}}, 0.0205314},
    {{{{-0.17487, 0.447916, 0.367201}, {-0.405259, 0.249607, -0.354079}, {0.356029, 0.0918984, -0.132271}}}, 0.26174},
}};

TEST(ReferenceDirect, CourseScenes) {
  for (const DirectCase& test : kDirect) {
    const auto& v = test.vertices;
    EXPECT_NEAR(0.5 / kPi * polygon_irradiance({v[0], v[1], v[2]}, {0, 1, 0}), test.reference, 2e-6);
    for (const Strategy& strategy : kStrategies) {
      Scene scene = floor_scene();
      add(scene, triangle(v[0], v[1], v[2]), diffuse(0.0), Vec3(1.0));
      set_strategy(scene, strategy);
      const Estimate e = estimate(scene, 200000);
      EXPECT_LT(e.t(test.reference), kMaxT)
          << strategy.name << ": " << e.mean << " ± " << e.standard_error << ", expected " << test.reference;
      EXPECT_EQ(e.rejected, 0u);
      EXPECT_LT(e.standard_error, 0.012 * test.reference) << "too noisy to tell";
    }
  }
}

/// `count` lights in separate sectors around the vertical axis, so that none hides another: triangles facing the
/// origin and spheres, of radiance and size spread over an order of magnitude. Returns the radiance the floor reflects.
double add_random_lights(Scene& scene, int count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(0.0, 1.0);
  double reflected = 0.0;
  for (int i = 0; i < count; ++i) {
    const double phi = 2.0 * kPi * (i + 0.5) / count;
    const double height = 0.35 + 0.4 * u(random);
    const double horizontal = std::sqrt(1.0 - height * height);
    const Vec3 toward(horizontal * std::cos(phi), height, horizontal * std::sin(phi));
    const double distance = 0.5 + u(random);
    const double room = 0.8 * distance * std::min(height, horizontal * std::sin(std::min(kPi / 2, kPi / count)));
    const double radiance = std::pow(10.0, u(random));
    if (i % 2 == 1) {
      const Sphere sphere{.center = distance * toward, .radius = room * (0.2 + 0.8 * u(random))};
      reflected += radiance * sphere_irradiance(sphere, {0, 1, 0});
      add(scene, sphere, diffuse(0.0), Vec3(radiance));
      continue;
    }
    const Frame frame(-toward);
    std::array<Vec3, 3> p;
    for (int k = 0; k < 3; ++k) {
      const double angle = 2.0 * kPi * (k + 0.6 * u(random)) / 3.0;
      p[k] = distance * toward + frame.to_world(room * Vec3(std::cos(angle), std::sin(angle), 0.3 * u(random)));
    }
    reflected += radiance * polygon_irradiance({p[0], p[1], p[2]}, {0, 1, 0});
    add(scene, triangle(p[0], p[1], p[2]), diffuse(0.0), Vec3(radiance));
  }
  const auto& floor = std::get<DiffuseBsdf>(scene.materials[0].bsdf);
  return reflected * luminance(floor.albedo.value) / kPi;
}

TEST(ReferenceDirect, RandomLightsOfMixedShape) {
  std::mt19937_64 random(20240607);
  for (const int count : {1, 2, 7, 50}) {
    for (int repetition = 0; repetition < 3; ++repetition) {
      Scene scene = floor_scene(0.2 + 0.3 * repetition);
      const double expected = add_random_lights(scene, count, random);
      for (const Strategy& strategy : kStrategies) {
        set_strategy(scene, strategy);
        const Estimate e = estimate(scene, 100000, 7);
        EXPECT_LT(e.t(expected), kMaxT) << count << " lights, " << strategy.name << ": " << e.mean << " ± "
                                        << e.standard_error << ", expected " << expected;
        EXPECT_LT(e.standard_error, 0.05 * expected) << "too noisy to tell";
      }
    }
  }
}

TEST(ReferenceDirect, AWrongAnswerIsFound) {
  // The test above has power: an answer 2 % off is refused for every strategy.
  std::mt19937_64 random(5);
  Scene scene = floor_scene();
  const double expected = 1.02 * add_random_lights(scene, 7, random);
  for (const Strategy& strategy : kStrategies) {
    set_strategy(scene, strategy);
    EXPECT_GT(estimate(scene, 1000000).t(expected), kMaxT) << strategy.name;
  }
}

}  // namespace
}  // namespace etendue::reference::test
