/// Heaps of primitives: twins cost nothing, and what no walk can pass is told in the scene's words.

#include <cstring>

#include "core/errors.h"
#include "device_test.h"
#include "reference_scenes.h"

namespace etendue::test {
namespace {

using reference::test::add;
using reference::test::diffuse;
using reference::test::look_at;

class RendererCrowds : public DeviceTest {
 protected:
  /// A lamp and a ball, over which stands what is added.
  static Scene room() {
    Scene scene;
    add(scene, Sphere{{0, -1, 0}, 1.0}, diffuse(0.5));
    add(scene, Sphere{{1, 3, 2}, 0.3}, diffuse(0.0), glm::dvec3(20.0));
    scene.camera.width = 24;
    scene.camera.height = 16;
    scene.camera.world_from_camera = look_at({0, 0.5, 6}, {0, 0, 0}, {0, 1, 0});
    scene.integrator.max_depth = 4;
    return scene;
  }
  static TriangleMesh triangles(std::uint32_t count, double step) {
    TriangleMesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double z = step * i;
      for (const glm::dvec3& p : {glm::dvec3(-2, -2, z), glm::dvec3(2, -2, z), glm::dvec3(0, 2, z)})
        mesh.positions.push_back(p);
      mesh.triangles.push_back(glm::uvec3(0, 1, 2) + 3 * i);
    }
    return mesh;
  }
  static Film render(const Scene& scene) {
    Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
    std::vector<RejectedSample> rejected;
    make_gpu_renderer(scene, {.seed = 3}, renderer_options())->render({0, 4}, film, {}, rejected);
    return film;
  }
  static bool same_bytes(const Film& a, const Film& b) {
    return a.pixels().size() == b.pixels().size() &&
           std::memcmp(a.pixels().data(), b.pixels().data(), a.pixels().size() * sizeof(FilmPixel)) == 0;
  }
};

TEST_F(RendererCrowds, SeventyThousandTwinsAreThePictureOfOne) {
  Scene one = room(), many = room();
  add(one, triangles(1, 0.0), diffuse(0.7));
  add(many, triangles(70000, 0.0), diffuse(0.7));
  EXPECT_TRUE(same_bytes(render(one), render(many)));
}

TEST_F(RendererCrowds, SeventyThousandEqualSpheresAreThePictureOfOne) {
  Scene one = room(), many = room();
  for (int i = 0; i < 70000; ++i) add(many, Sphere{{0.3, 0.5, 0.2}, 0.7}, diffuse(0.7));
  add(one, Sphere{{0.3, 0.5, 0.2}, 0.7}, diffuse(0.7));
  EXPECT_TRUE(same_bytes(render(one), render(many)));
}

TEST_F(RendererCrowds, AHeapThatNoWalkCanPassIsNamedAsOne) {
  Scene scene = room();
  add(scene, triangles(70000, 1e-6), diffuse(0.7));
  if (!is_lavapipe()) GTEST_SKIP() << "a GPU passes it";
  try {
    render(scene);
    FAIL() << "rendered";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::scene);
    EXPECT_NE(std::string(error.what()).find("paths take more than 60000 steps each"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace etendue::test
