/// Light from outside on the device against the reference: cells, directions, densities, radiance, at every size.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "device_test.h"
#include "reference/environment.h"
#include "reference/vec.h"
#include "reference_scenes.h"
#include "sky_pictures.h"

namespace etendue::test {
namespace {

using reference::Environment;
using reference::Vec3;

class DeviceEnvironment : public DeviceTest {
 protected:
  std::vector<gpu::EnvironmentAnswer> look(const Scene& scene, const std::vector<gpu::EnvironmentCase>& cases) {
    const CompiledScene compiled = compile_scene(scene);
    KernelRun kernel{kernels::environment, "environment", &compiled, {}};
    kernel.view = view_of(scene);
    return run<gpu::EnvironmentAnswer>(kernel, cases);
  }

  void compare(const Scene& scene, const char* what) {
    SCOPED_TRACE(what);
    double lights_power = 0.0;
    for (const Instance& instance : scene.instances) {
      if (const AreaEmitter* emitter = scene.emitter_of(instance)) lights_power = emitter != nullptr ? kLampPower : 0.0;
    }
    const Environment environment(scene, lights_power);
    std::vector<gpu::EnvironmentCase> cases;
    Random random(7);
    for (int i = 0; i < 4000; ++i) {
      // Also the least word and the largest: what lies beyond the last entry must not be found.
      const gpu::uint a = i % 50 == 0 ? ~0u : i % 50 == 1 ? 0u : random.word();
      const gpu::uint b = i % 40 == 0 ? ~0u : i % 40 == 1 ? 0u : random.word(), c = random.word();
      cases.push_back({{a, b, c, random.word()}, glm::vec3(random.direction()), 0});
    }
    const auto answers = look(scene, cases);
    int other_cell = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const auto& answer = answers[i];
      const gpu::uvec4 words = cases[i].words;
      const auto sample =
          environment.sample({words.x, words.y, reference::unit_float(words.z), reference::unit_float(words.w)});
      ASSERT_EQ(answer.chosen, sample ? 1u : 0u) << i;
      if (sample) {
        ASSERT_EQ(answer.cell, sample->cell) << i;
        EXPECT_LT(glm::length(Vec3(answer.wi) - sample->wi), 2e-6) << i;
        EXPECT_NEAR(answer.pdf_w, sample->pdf_w, 2e-6 * sample->pdf_w) << i;
        EXPECT_LT(glm::length(Vec3(answer.radiance) - sample->radiance), 1e-4 * (1.0 + glm::length(sample->radiance)))
            << i;
      }
      const Vec3 w = glm::normalize(Vec3(cases[i].w));
      const Vec3 seen = environment.radiance(w);
      // Single precision finds the place in a picture of W columns to some 5e-8 W of a texel.
      const double slack = 5e-6 * (scene.sky.picture ? scene.sky.picture->bitmap->width : 1);
      EXPECT_LT(glm::length(Vec3(answer.seen) - seen), slack + 2e-3 * (0.1 + glm::length(seen))) << i;
      const double pdf_w = environment.pdf_w(w);
      if (std::abs(answer.seen_pdf_w - pdf_w) > 1e-5 * pdf_w) ++other_cell;
    }
    EXPECT_LE(other_cell, 12) << "directions within rounding of the edge of a cell";
  }

  static constexpr double kLampPower = 2.0 * (0.212671 + 0.715160 + 0.072169);  // radiance 2, area 1
};

struct Size {
  std::uint32_t width, height;
};

TEST_F(DeviceEnvironment, AgreesWithTheReferenceAtEverySize) {
  for (const auto rows : {SkyPicture::Rows::bands, SkyPicture::Rows::circles}) {
    for (const Size& size :
         {Size{1, 1}, Size{3, 1}, Size{1, 3}, Size{2, 2}, Size{7, 5}, Size{64, 33}, Size{8191, 37}}) {
      Scene scene;
      scene.sky.picture = make_random_sky(size.width, size.height, rows);
      scene.sky.world_from_sky = oblique_turn();
      compare(scene,
              fmt::format("{}x{} {}", size.width, size.height, rows == SkyPicture::Rows::bands ? "bands" : "circles")
                  .c_str());
    }
  }
}

TEST_F(DeviceEnvironment, AgreesBesideALamp) {
  Scene scene;
  scene.sky.picture = make_random_sky(16, 9, SkyPicture::Rows::bands);
  reference::test::add(scene, reference::test::quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), reference::test::diffuse(0.5),
                       glm::dvec3(2.0));
  compare(scene, "picture");
  scene.sky = {.top = glm::dvec3(1.0, 2.0, 3.0), .horizon = glm::dvec3(0.5, 0.0, 0.1)};
  compare(scene, "gradient");
  scene.sky = {.top = glm::dvec3(1.0), .horizon = glm::dvec3(0.0), .picture = {}, .world_from_sky = oblique_turn()};
  compare(scene, "turned gradient");
}

TEST_F(DeviceEnvironment, RowsThatAreBlackAreLeftOut) {
  Scene scene;
  // Light in one texel only: all that is before and behind it in its row, and all other rows, have no weight.
  for (const auto& [x, y] : {std::pair(0u, 0u), std::pair(8u, 4u), std::pair(3u, 2u), std::pair(0u, 4u)}) {
    scene.sky.picture =
        make_sky_picture(9, 5, SkyPicture::Rows::bands, [x = x, y = y](std::uint32_t i, std::uint32_t j) {
          return i == x && j == y ? glm::vec3(1.0f, 2.0f, 3.0f) : glm::vec3(0.0f);
        });
    compare(scene, fmt::format("light at {}, {}", x, y).c_str());
  }
}

}  // namespace
}  // namespace etendue::test
