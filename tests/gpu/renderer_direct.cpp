/// Direct light on a floor from any number of lamps, against Lambert's closed form computed here; the same at other
/// sizes and places.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>

#include "device_test.h"
#include "reference/frame.h"
#include "reference_scenes.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::diffuse;
using reference::test::floor_scene;
using reference::test::kStrategies;
using reference::test::polygon_irradiance;
using reference::test::sphere_irradiance;
using reference::test::Strategy;
using reference::test::triangle;

constexpr double kPi = std::numbers::pi;
constexpr double kMaxT = 4.8;  // |t| of a correct estimator exceeds it once in a million

class RendererDirect : public DeviceTest {
 protected:
  struct Estimate {
    double mean, standard_error;
  };
  Estimate estimate(const Scene& scene, std::uint32_t samples) {
    Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
    std::vector<RejectedSample> rejected;
    make_gpu_renderer(scene, {.seed = 5, .quantity = FilmQuantity::luminance}, renderer_options())
        ->render({0, samples}, film, {}, rejected);
    EXPECT_EQ(film.rejected(), 0u);
    const Moments m = film_moments(film, 0);
    return {static_cast<double>(m.mean), static_cast<double>(std::sqrt(m.variance / static_cast<long double>(m.n)))};
  }
  void expect_mean(const Scene& scene, double expected, const std::string& what, std::uint32_t samples = 60000) {
    const Estimate e = estimate(scene, samples);
    EXPECT_LT(std::abs(e.mean - expected), kMaxT * e.standard_error + 1e-5 * expected)
        << what << ": " << e.mean << " ± " << e.standard_error << ", expected " << expected;
    EXPECT_LT(e.standard_error, 0.06 * expected) << what << ": too noisy to tell";
  }
};

// Adds `count` lamps over the floor, each in a sector of the sky of its own so that none hides another: triangles,
// quads and spheres in turn, strengths over two decades. Returns the irradiance at the origin.
double add_lamps(Scene& scene, int count, Random& random) {
  const glm::dvec3 up(0, 1, 0);
  double irradiance = 0.0;
  for (int i = 0; i < count; ++i) {
    const double height = 0.35 + 0.5 * random.unit(), horizontal = std::sqrt(1.0 - height * height),
                 phi = 2.0 * kPi * (i + 0.5) / count;
    const glm::dvec3 toward(horizontal * std::cos(phi), height, horizontal * std::sin(phi));
    const double distance = 0.6 + random.unit();
    const double room = 0.9 * distance * std::min(height, horizontal * std::sin(std::min(kPi / 2, kPi / count)));
    const double radiance = std::pow(10.0, 2.0 * random.unit() - 1.0);
    const glm::dvec3 center = distance * toward;
    if (i % 3 == 2) {
      const Sphere sphere{.center = center, .radius = room * (0.3 + 0.7 * random.unit())};
      irradiance += radiance * sphere_irradiance(sphere, up);
      add(scene, sphere, diffuse(0.0), glm::dvec3(radiance));
      continue;
    }
    const reference::Frame frame(-toward);
    const int corners = 3 + i % 3;
    TriangleMesh mesh;
    const double tilt = 0.6 * random.unit() - 0.3;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2.0 * kPi * k / corners + 0.3;
      const glm::dvec3 in_plane(std::cos(angle), std::sin(angle), tilt * std::cos(angle));
      mesh.positions.push_back(center + frame.to_world(0.9 * room * in_plane));
    }
    for (std::uint32_t k = 2; k < static_cast<std::uint32_t>(corners); ++k) mesh.triangles.push_back({0, k - 1, k});
    irradiance += radiance * polygon_irradiance({mesh.positions.begin(), mesh.positions.end()}, up);
    add(scene, mesh, diffuse(0.0), glm::dvec3(radiance));
  }
  return irradiance;
}

TEST_F(RendererDirect, AnyNumberOfLamps) {
  Random random(1);
  for (const int count : {1, 2, 7, 50}) {
    const double albedo = 0.3 + 0.1 * (count % 5);
    Scene scene = floor_scene(albedo);
    const double expected = albedo / kPi * add_lamps(scene, count, random);
    for (const Strategy& strategy : kStrategies) {
      reference::test::set_strategy(scene, strategy);
      expect_mean(scene, expected, std::to_string(count) + " lamps, " + strategy.name);
    }
  }
}

// Maps a scene to another size and place.
void place(Scene& scene, double scale, const glm::dvec3& offset) {
  const glm::dmat4 motion = glm::scale(glm::translate(glm::dmat4(1.0), offset), glm::dvec3(scale));
  for (Instance& instance : scene.instances) instance.world_from_object = motion * instance.world_from_object;
  glm::dvec4& origin = scene.camera.world_from_camera[3];
  origin = glm::dvec4(glm::dvec3(origin) * scale + offset, 1.0);
  scene.camera.near_clip *= scale;
  scene.camera.far_clip *= scale;
}

TEST_F(RendererDirect, AnySizeAndPlace) {
  struct Place {
    double scale;
    glm::dvec3 offset;
  };
  for (const Place& p :
       {Place{1e-3, {0, 0, 0}}, Place{1e3, {0, 0, 0}}, Place{1.0, {1e4, 0, -3e4}}, Place{1e-3, {1, 1, 1}}}) {
    Random random(2);
    Scene scene = floor_scene();
    const double expected = 0.5 / kPi * add_lamps(scene, 7, random);
    place(scene, p.scale, p.offset);
    for (const Strategy& strategy : {kStrategies[0], kStrategies[2]}) {
      reference::test::set_strategy(scene, strategy);
      expect_mean(scene, expected, "scale " + std::to_string(p.scale) + ", " + strategy.name);
    }
  }
}

TEST_F(RendererDirect, LampsOfVeryDifferentStrengthAndSize) {
  // One lamp carries nearly all the power, far away; a weak near one gives most of the light.
  Scene scene = floor_scene();
  const glm::dvec3 up(0, 1, 0);
  const Sphere near{.center = {0.02, 0.02, 0.0}, .radius = 0.005};
  const TriangleMesh far = triangle({-30, 500, -30}, {30, 500, -30}, {0, 500, 40});
  const double expected =
      0.5 / kPi *
      (2.0 * sphere_irradiance(near, up) + 20.0 * polygon_irradiance({far.positions.begin(), far.positions.end()}, up));
  add(scene, near, diffuse(0.0), glm::dvec3(2.0));
  add(scene, far, diffuse(0.0), glm::dvec3(20.0));
  for (const Strategy& strategy : {kStrategies[0], kStrategies[2]}) {
    reference::test::set_strategy(scene, strategy);
    expect_mean(scene, expected, strategy.name, 400000);
  }
}

TEST_F(RendererDirect, AWrongAnswerIsFound) {
  Random random(3);
  Scene scene = floor_scene();
  const double wrong = 1.05 * 0.5 / kPi * add_lamps(scene, 7, random);
  for (const Strategy& strategy : kStrategies) {
    reference::test::set_strategy(scene, strategy);
    const Estimate e = estimate(scene, 250000);
    EXPECT_GT(std::abs(e.mean - wrong), kMaxT * e.standard_error) << strategy.name;
  }
}

}  // namespace
}  // namespace etendue::test
