/// The clear sky and its sun [Preetham1999].

#include <cmath>
#include <numbers>

#include "formats/dialect/daylight.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

constexpr double kCandelas = 683.0 * 106.856895;

double luminance(const glm::dvec3& rgb) {
  return glm::dot(rgb, glm::dvec3(0.212671, 0.715160, 0.072169));
}

TEST(Daylight, TheZenithHasTheLuminanceOfThePaper) {
  const Daylight daylight{.turbidity = 3.0, .sun = glm::normalize(glm::dvec3(0.3, 0.8, 0.2))};
  EXPECT_NEAR(luminance(sky_radiance(daylight, {0, 1, 0})) * kCandelas, 12061.66, 1.0);
  const glm::dvec3 zenith = sky_radiance(daylight, {0, 1, 0});
  EXPECT_GT(zenith.z, zenith.x);  // it is blue
}

TEST(Daylight, TheSunLightsAsMuchAsPeopleMeasure) {
  const auto klux = [](double turbidity, double height) {
    const Daylight daylight{.turbidity = turbidity, .sun = {std::cos(height), std::sin(height), 0.0}};
    return luminance(sun_irradiance(daylight)) * kCandelas / 1000.0;
  };
  // A surface that faces a high sun in clear air has 90 to 120 thousand lux, at sunset some thousand.
  EXPECT_GT(klux(2.0, 1.5), 90.0);
  EXPECT_LT(klux(2.0, 1.5), 130.0);
  EXPECT_LT(klux(4.0, 1.5), klux(2.0, 1.5));
  EXPECT_LT(klux(3.0, 0.05), 20.0);
  const glm::dvec3 low = sun_radiance({.turbidity = 3.0, .sun = {std::cos(0.05), std::sin(0.05), 0.0}});
  EXPECT_GT(low.x, 4.0 * low.z);  // red
}

TEST(Daylight, ThePictureKeepsTheSunsLight) {
  for (const std::uint32_t width : {64u, 512u, 2048u}) {
    for (const double radius : {0.0, 1.0, 20.0}) {
      Daylight daylight{.sun = glm::normalize(glm::dvec3(0.5, 0.6, -0.2)), .sky_scale = 0.0};
      daylight.width = width;
      daylight.sun_radius = radius;
      const auto picture = make_daylight(daylight);
      double sum = 0.0;
      for (std::uint32_t y = 0; y < picture->height; ++y) {
        const double step = std::numbers::pi / picture->height;
        const double solid_angle = 2.0 * std::numbers::pi / width * (std::cos(step * y) - std::cos(step * (y + 1.0)));
        for (std::uint32_t x = 0; x < width; ++x) sum += solid_angle * picture->stored(x, y, 1);
      }
      const double expected = sun_irradiance(daylight).y;
      EXPECT_NEAR(sum / expected, 1.0, 1e-4) << width << ' ' << radius;
    }
  }
}

TEST(Daylight, TheSunStandsWhereItDoes) {
  // Equinox on the equator, on the meridian of the clock: overhead at noon but for the equation of time.
  const glm::dvec3 noon =
      sun_direction({.latitude = 0.0, .longitude = 0.0, .timezone = 0.0, .day_of_year = 81, .hour = 12.0});
  EXPECT_GT(noon.y, 0.999);
  const PlaceAndTime summer{.latitude = 48.0, .longitude = 15.0, .timezone = 1.0, .day_of_year = 172, .hour = 12.0};
  const glm::dvec3 high = sun_direction(summer);
  EXPECT_NEAR(std::asin(high.y) * 180.0 / std::numbers::pi, 90.0 - 48.0 + 23.45, 0.5);
  EXPECT_GT(high.z, 0.0);  // in the south
  PlaceAndTime morning = summer;
  morning.hour = 7.0;
  EXPECT_GT(sun_direction(morning).x, 0.5);  // in the east
}

TEST(Daylight, NightIsRefused) {
  const Parsed parsed =
      parse(scene_around("<emitter type=\"sunsky\"><vector name=\"sunDirection\" value=\"1 -0.1 0\"/></emitter>"));
  EXPECT_FALSE(parsed.file.has_value());
  EXPECT_NE(all_messages(parsed.diagnostics).find("below the horizon"), std::string::npos);
}

}  // namespace
}  // namespace etendue::testing
