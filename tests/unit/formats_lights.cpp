/// Lights without extent, in scene files.

#include <cmath>
#include <numbers>

#include "formats_testing.h"
#include "scene/film_unit.h"

namespace etendue::testing {
namespace {

DeltaLight light_of(const std::string& type, const std::string& content) {
  const Parsed parsed = parse(scene_around("<emitter type=\"" + type + "\">" + content + "</emitter>"));
  EXPECT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  return parsed.file ? parsed.scene().delta_lights.at(0) : DeltaLight{};
}

const std::string kWhite = "<color name=\"intensity\" value=\"1 1 1\"/>";

TEST(SceneLights, APointHasAPlaceAndAnIntensity) {
  const DeltaLight light =
      light_of("point", "<point name=\"position\" value=\"1 2 3\"/><color name=\"power\" value=\"1 2 3\"/>");
  EXPECT_EQ(light.type, DeltaLight::Type::point);
  EXPECT_EQ(light.origin(), glm::dvec3(1, 2, 3));
  EXPECT_NEAR(light.intensity.value.y, 2.0 / (4.0 * std::numbers::pi), 1e-12);
}

TEST(SceneLights, ASpotShinesAtItsTarget) {
  const DeltaLight light = light_of("spot", kWhite +
                                                "<point name=\"position\" value=\"1 2 3\"/><point name=\"target\" "
                                                "value=\"1 -2 3\"/><float name=\"cutoffAngle\" value=\"40\"/>");
  EXPECT_LT(glm::length(light.axis(2) - glm::dvec3(0, -1, 0)), 1e-12);
  EXPECT_NEAR(glm::determinant(glm::dmat3(light.world_from_light)), 1.0, 1e-12);
  EXPECT_EQ(light.cutoff, 40.0);
  EXPECT_EQ(light.beam_width, 30.0);
  EXPECT_EQ(light.falloff, DeltaLight::Falloff::linear);
}

TEST(SceneLights, OtherWordsForAConeBringTheirFalloff) {
  const DeltaLight light =
      light_of("spot", kWhite + "<float name=\"totalWidth\" value=\"60\"/><float name=\"falloffStart\" value=\"5\"/>");
  EXPECT_EQ(light.cutoff, 60.0);
  EXPECT_EQ(light.beam_width, 5.0);
  EXPECT_EQ(light.falloff, DeltaLight::Falloff::quartic);
}

TEST(SceneLights, AProjectorHasTheSlopeOfItsPicture) {
  const DeltaLight light = light_of("projector",
                                    "<color name=\"irradiance\" value=\"1 1 1\"/><float name=\"scale\" value=\"3\"/>"
                                    "<float name=\"fov\" value=\"90\"/><float name=\"aspect\" value=\"2\"/>");
  EXPECT_EQ(light.intensity.value, glm::dvec3(3.0));
  EXPECT_NEAR(light.slope.x, 1.0, 1e-12);
  EXPECT_NEAR(light.slope.y, 0.5, 1e-12);
}

TEST(SceneLights, DirectionsGoByTwoNames) {
  const std::string direction = "<vector name=\"direction\" value=\"0 0 -2\"/>";
  for (const char* word : {"irradiance", "radiance"}) {
    const std::string color = std::string("<color name=\"") + word + "\" value=\"1 2 3\"/>";
    const DeltaLight light = light_of(word == std::string("radiance") ? "distant" : "directional", direction + color);
    EXPECT_EQ(light.type, DeltaLight::Type::directional);
    EXPECT_EQ(light.axis(2), glm::dvec3(0, 0, -1));
    EXPECT_EQ(light.intensity.value, glm::dvec3(1, 2, 3));
  }
}

TEST(SceneLights, TheFilmHasRoomForWhatIsNear) {
  Scene scene;
  scene.add(Sphere{});
  EXPECT_EQ(radiance_exponent(scene), 0);
  scene.delta_lights.push_back({.intensity = glm::dvec3(2.5)});
  // The box of the sphere has half a diagonal of √3.
  EXPECT_EQ(radiance_exponent(scene), 22);
  scene.delta_lights.push_back({.intensity = glm::dvec3(2.5)});
  EXPECT_EQ(radiance_exponent(scene), 23);
  scene.delta_lights = {{.type = DeltaLight::Type::directional, .intensity = glm::dvec3(3.0)}};
  EXPECT_EQ(radiance_exponent(scene), 2);
}

}  // namespace
}  // namespace etendue::testing
