// Course scenes call the same things by many words.

#include <fmt/format.h>

#include "formats/nori/plugins.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

Scene read_good(const std::string& text) {
  Parsed parsed = parse(text);
  EXPECT_TRUE(parsed.file.has_value()) << text << "\n" << all_messages(parsed.diagnostics);
  return parsed.file ? parsed.scene() : Scene{};
}

Scene with_camera(const std::string& camera) {
  return read_good("<scene><integrator type=\"path\"/>" + camera + "<mesh type=\"sphere\"/></scene>");
}

TEST(Spellings, CapitalsHyphensAndUnderscoresDoNotMatter) {
  const Dialect& dialect = nori_dialect();
  for (const char* word : {"pointLight", "PointLight", "point_light", "point-light", "POINT", "pointlight"})
    EXPECT_EQ(dialect.canonical_type("emitter", word), "point") << word;
  EXPECT_EQ(dialect.canonical_type("bsdf", "RoughConductor"), "roughconductor");
  EXPECT_EQ(dialect.canonical_type("bsdf", "rough_conductor"), "roughconductor");
  EXPECT_EQ(dialect.canonical_type("bsdf", "rough_conductors"), "rough_conductors");
  EXPECT_EQ(dialect.canonical_type("bsdf", "rough"), "rough");
  EXPECT_EQ(dialect.canonical_type("bsdf", ""), "");
  EXPECT_EQ(dialect.canonical_type("bsdf", "_"), "_");
  EXPECT_EQ(dialect.canonical_type("integrator", "directLighting"), "direct_ems");
  const Plugin& lens = *dialect.find("camera", "thinLens");
  EXPECT_STREQ(dialect.find_parameter(lens, "LensRadius")->name, "apertureRadius");
  EXPECT_STREQ(dialect.find_parameter(lens, "to_world")->name, "toWorld");
  EXPECT_EQ(dialect.find_parameter(lens, "lens"), nullptr);
  EXPECT_EQ(dialect.find_parameter(lens, ""), nullptr);
}

TEST(Spellings, EveryAliasMeansARow) {
  const Dialect& dialect = nori_dialect();
  for (const TypeAliases& aliases : dialect.type_aliases) {
    for (const std::string_view word : aliases.words) {
      ASSERT_NE(dialect.find(aliases.tag, word), nullptr) << word;
      EXPECT_EQ(dialect.find(aliases.tag, word)->type, aliases.type) << word;
    }
  }
  for (const UnsupportedTypes& row : dialect.unsupported_types) {
    for (const std::string_view type : row.types) EXPECT_EQ(dialect.find(row.tag, type), nullptr) << type;
  }
}

TEST(Spellings, APerspectiveCameraMayHaveALens) {
  const Scene lens = with_camera(
      R"(<camera type="perspective"><float name="lensRadius" value="0.2"/><float name="focal_distance" value="5"/></camera>)");
  EXPECT_EQ(lens.camera.type, Camera::Type::thin_lens);
  EXPECT_EQ(lens.camera.aperture.radius, 0.2);
  EXPECT_EQ(lens.camera.aperture.focus_distance, 5.0);
  EXPECT_EQ(with_camera(R"(<camera type="perspective"><float name="apertureRadius" value="0"/></camera>)").camera.type,
            Camera::Type::perspective);
  const Parsed parsed = parse(
      "<scene><integrator type=\"path\"/><camera type=\"perspective\"><float name=\"apertureRadius\" "
      "value=\"1\"/></camera></scene>");
  EXPECT_NE(all_messages(parsed.diagnostics).find("needs a focus distance"), std::string::npos);
}

TEST(Spellings, DisneysMaterialIsPrincipled) {
  const Scene scene = read_good(scene_around(R"(<mesh type="sphere"><bsdf type="disney">
    <color name="baseColor" value="0.5 0.2 0.1"/><float name="metallic" value="0.3"/><float name="specular" value="0.5"/>
    <float name="specularTint" value="0.2"/><float name="clearcoatGloss" value="0.4"/><float name="sheenTint" value="0.6"/>
    <float name="subsurface" value="0.7"/></bsdf></mesh>)"));
  const auto& bsdf = std::get<PrincipledBsdf>(scene.materials.at(0).bsdf);
  EXPECT_EQ(bsdf.base_color.value, glm::dvec3(0.5, 0.2, 0.1));
  EXPECT_EQ(bsdf.spec_tint.value, 0.2);
  EXPECT_EQ(bsdf.clearcoat_gloss.value, 0.4);
  EXPECT_EQ(bsdf.sheen_tint.value, 0.6);
  EXPECT_EQ(bsdf.flatness.value, 0.7);
  EXPECT_NEAR(bsdf.eta.value, 1.5, 1e-12);  // ((1.5 − 1)/(1.5 + 1))² = 0.08 · 0.5
}

TEST(Spellings, OtherIntegratorsOfTheSameLight) {
  for (const char* type : {"photonmapper", "photonMapper", "PPM", "bdpt", "mlt", "path_tracer", "PathTracing"}) {
    const Scene scene =
        read_good(fmt::format("<scene><integrator type=\"{}\"/><camera type=\"perspective\"/>"
                              "<mesh type=\"sphere\"/></scene>",
                              type));
    EXPECT_EQ(scene.integrator.type, Integrator::Type::path) << type;
    EXPECT_TRUE(scene.integrator.nee && scene.integrator.mis) << type;
    EXPECT_EQ(scene.integrator.max_depth, Integrator::kUnlimitedDepth) << type;
  }
}

TEST(Spellings, WordsOfCoursesForLightsAndColours) {
  const Scene scene = read_good(scene_around(R"(
    <emitter type="pointLight"><point name="position" value="2 4 2"/><color name="radiance" value="20 20 20"/></emitter>
    <mesh type="sphere"><bsdf type="diffuse"><texture name="albedo" type="constant_color">
      <color name="value" value="0.1 0.2 0.3"/></texture></bsdf></mesh>
    <mesh type="sphere"><bsdf type="roughPlastic"><color name="kd" value="0.3 0.2 0.1"/></bsdf></mesh>)"));
  EXPECT_EQ(scene.delta_lights.at(0).intensity.value, glm::dvec3(20.0));
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.materials.at(0).bsdf).albedo.value, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(std::get<RoughPlasticBsdf>(scene.materials.at(1).bsdf).diffuse_reflectance.value,
            glm::dvec3(0.3, 0.2, 0.1));
}

TEST(Spellings, FlippedSpheres) {
  const Scene scene =
      read_good(scene_around("<mesh type=\"sphere\"><boolean name=\"flipNormals\" value=\"true\"/></mesh>"));
  EXPECT_TRUE(scene.instances.at(0).flip_normals);
}

}  // namespace
}  // namespace etendue::testing
