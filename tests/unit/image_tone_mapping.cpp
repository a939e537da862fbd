/// What --tonemap and --exposure make of radiance, against the equations of docs/image_files.md.

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "image/tone_mapping.h"
#include "image_testing.h"

namespace etendue {
namespace {

using testing_image::slurp;
using testing_image::TempFolder;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

double grey(float linear, ToneMap tone_map, double exposure = 0.0) {
  const glm::dvec3 shown = tone_mapped(glm::vec3(linear), {.tone_map = tone_map, .exposure = exposure});
  EXPECT_DOUBLE_EQ(shown.x, shown.y);
  EXPECT_DOUBLE_EQ(shown.x, shown.z);
  return shown.x;
}

TEST(ToneMapping, NamesStandForOperators) {
  for (const ToneMap tone_map : {ToneMap::none, ToneMap::reinhard, ToneMap::aces})
    EXPECT_EQ(tone_map_of(name_of(tone_map)), tone_map);
  EXPECT_EQ(tone_map_names(), (std::vector<std::string>{"none", "reinhard", "aces"}));
}

TEST(ToneMapping, ExposureCountsInStops) {
  EXPECT_EQ(grey(0.3f, ToneMap::none), static_cast<double>(0.3f));
  EXPECT_EQ(grey(0.25f, ToneMap::none, 1.0), 0.5);
  EXPECT_EQ(grey(0.25f, ToneMap::none, -2.0), 0.0625);
  EXPECT_EQ(grey(3.0f, ToneMap::none), 3.0);
  // It comes before the operator.
  EXPECT_NEAR(grey(0.5f, ToneMap::reinhard, 1.0), 0.5, 1e-15);
}

TEST(ToneMapping, ReinhardCompressesTheLuminanceAndKeepsTheHue) {
  EXPECT_NEAR(grey(1.0f, ToneMap::reinhard), 0.5, 1e-12);
  EXPECT_NEAR(grey(3.0f, ToneMap::reinhard), 0.75, 1e-12);
  EXPECT_EQ(grey(0.0f, ToneMap::reinhard), 0.0);
  const glm::vec3 orange(4.0f, 2.0f, 0.5f);
  const glm::dvec3 shown = tone_mapped(orange, {.tone_map = ToneMap::reinhard});
  const double luminance = 4.0 * 0.212671 + 2.0 * 0.715160 + 0.5 * 0.072169;
  EXPECT_NEAR(shown.x, 4.0 / (1.0 + luminance), 1e-12);
  EXPECT_NEAR(shown.y / shown.x, 0.5, 1e-12);
  EXPECT_NEAR(shown.z / shown.x, 0.125, 1e-12);
}

TEST(ToneMapping, AcesIsNarkowiczsCurve) {
  // (x (2.51 x + 0.03)) / (x (2.43 x + 0.59) + 0.14), by hand.
  EXPECT_NEAR(grey(1.0f, ToneMap::aces), 2.54 / 3.16, 1e-12);
  EXPECT_NEAR(grey(0.18f, ToneMap::aces), 0.26690, 1e-5);
  EXPECT_NEAR(grey(0.5f, ToneMap::aces), 0.6425 / 1.0425, 1e-12);
  EXPECT_EQ(grey(0.0f, ToneMap::aces), 0.0);
  EXPECT_EQ(grey(100.0f, ToneMap::aces), 1.0);  // the quotient is 1.03
  // Each channel by itself.
  const glm::dvec3 shown = tone_mapped({1.0f, 0.5f, 0.0f}, {.tone_map = ToneMap::aces});
  EXPECT_NEAR(shown.x, 2.54 / 3.16, 1e-12);
  EXPECT_NEAR(shown.y, 0.6425 / 1.0425, 1e-12);
  EXPECT_EQ(shown.z, 0.0);
}

TEST(ToneMapping, NumbersThatAreNoLight) {
  for (const ToneMap tone_map : {ToneMap::reinhard, ToneMap::aces}) {
    EXPECT_EQ(grey(-0.5f, tone_map), 0.0);
    EXPECT_EQ(grey(kInfinity, tone_map), 1.0);
    const glm::dvec3 shown = tone_mapped(glm::vec3(std::nanf("")), {.tone_map = tone_map});
    EXPECT_TRUE(std::isnan(shown.y));
    EXPECT_NEAR(grey(3e38f, tone_map), 1.0, 1e-12);
  }
  const glm::dvec3 red = tone_mapped({kInfinity, 0.0f, 2.0f}, {.tone_map = ToneMap::reinhard});
  EXPECT_EQ(red, glm::dvec3(1.0, 0.0, 1.0));
}

TEST(ToneMapping, PngFilesShowItAndSaySo) {
  const TempFolder folder;
  Image image{.width = 1, .height = 1, .pixels = {glm::vec3(1.0f)}, .metadata = {{"scene", "box"}}};
  write_png(folder / "plain.png", image);
  write_png(folder / "none.png", image, {.tone_map = ToneMap::none, .exposure = 0.0});
  EXPECT_EQ(slurp(folder / "plain.png"), slurp(folder / "none.png"));
  EXPECT_EQ(read_image(folder / "plain.png").metadata, (Metadata{{"scene", "box"}}));

  write_png(folder / "shown.png", image, {.tone_map = ToneMap::reinhard, .exposure = -1.5});
  const Image shown = read_image(folder / "shown.png");
  EXPECT_EQ(shown.metadata, (Metadata{{"scene", "box"}, {"toneMapping", "reinhard"}, {"exposure", "-1.5"}}));
  const double y = std::exp2(-1.5), expected = y / (1.0 + y);
  EXPECT_NEAR(shown.pixels[0].x, expected, 0.005);
}

}  // namespace
}  // namespace etendue
