// Scenes for Mitsuba: what is read of them, what is mapped, what is refused. Figures are those of Mitsuba 3.9.1
// (scalar_rgb): its `traverse` of the objects in question.

#include <algorithm>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "formats/mitsuba/mitsuba_reader.h"
#include "formats/mitsuba/plugins.h"
#include "formats/mitsuba/spectrum.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

using Files = std::map<std::string, std::string>;

struct Read {
  std::optional<Scene> scene;
  Diagnostics diagnostics;
  std::string messages() const { return all_messages(diagnostics); }
  std::string first_error() const {
    for (const Diagnostic& d : diagnostics.list()) {
      if (d.severity == Severity::error) return to_string(d);
    }
    return "";
  }
};

Read read(const std::string& text, const ReadOptions& options = {}, const Files& files = {}) {
  Read result;
  auto document = std::make_unique<XmlDocument>(text, "s.xml", result.diagnostics);
  if (!document->root()) return result;
  const TextLoader load = [&](const std::string& path) {
    const auto found = files.find(path);
    if (found == files.end()) throw Error(ErrorKind::scene, path + ": no such file");
    return found->second;
  };
  const auto none = [](const auto&...) -> std::optional<SerializedMesh> { return std::nullopt; };
  const auto picture = [](const std::string& path) {
    if (path != "p.png") throw Error(ErrorKind::file, path + ": no such file");
    Bitmap bitmap{.width = 2, .height = 1, .channels = 1, .format = BitmapFormat::u8, .color_space = ColorSpace::srgb};
    bitmap.texels = {std::byte{0}, std::byte{255}};
    return bitmap;
  };
  result.scene =
      parse_mitsuba_scene(std::move(document), options, {load_triangle, load, none, picture}, result.diagnostics);
  return result;
}

constexpr const char* kPicture = "<string name=\"filename\" value=\"p.png\"/>";
constexpr const char* kSensor = R"(<sensor type="perspective"><float name="fov" value="40"/></sensor>)";

/// A scene with the least it needs around `content`, all in line 1 up to `content` in line 2.
std::string around(const std::string& content) {
  return fmt::format("<scene version=\"3.0.0\">{}\n{}\n</scene>", kSensor, content);
}

std::string with_sensor(const std::string& sensor) {
  return fmt::format("<scene version=\"3.0.0\"><shape type=\"sphere\"/>{}</scene>", sensor);
}

/// The only material of a sphere with it.
Bsdf bsdf_of(const std::string& bsdf) {
  const Read result = read(around("<shape type=\"sphere\">" + bsdf + "</shape>"));
  EXPECT_TRUE(result.scene.has_value()) << result.messages();
  return result.scene ? result.scene->materials.at(0).bsdf : Bsdf{};
}
glm::dvec3 albedo_of(const std::string& reflectance) {
  const Bsdf bsdf = bsdf_of("<bsdf type=\"diffuse\">" + reflectance + "</bsdf>");
  return std::get<DiffuseBsdf>(bsdf).albedo.value;
}
glm::dvec3 radiance_of(const std::string& radiance) {
  const Read result = read(around("<shape type=\"sphere\"><emitter type=\"area\">" + radiance + "</emitter></shape>"));
  EXPECT_TRUE(result.scene.has_value()) << result.messages();
  return result.scene ? result.scene->emitters.at(0).radiance.value : glm::dvec3(-1.0);
}
void expect_color(const glm::dvec3& color, const glm::dvec3& expected, double relative = 1e-5) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(color[i], expected[i], relative * expected[i] + 1e-12) << "component " << i;
}

Camera camera_of(const std::string& sensor) {
  const Read result = read(with_sensor(sensor));
  EXPECT_TRUE(result.scene.has_value()) << result.messages();
  return result.scene ? result.scene->camera : Camera{};
}

/// Degrees that a film of this camera sees along its width.
double fov_across(const Camera& camera) {
  const double aspect = film_aspect(camera);
  using enum Camera::FovAxis;
  const bool by_x =
      camera.fov_axis == x || (camera.fov_axis == smaller && aspect > 1) || (camera.fov_axis == larger && aspect <= 1);
  const double side = camera.fov_axis == diagonal ? std::hypot(1.0, aspect) : by_x ? 1.0 : aspect;
  return glm::degrees(2.0 * std::atan(std::tan(glm::radians(camera.fov) / 2.0) / side));
}

TEST(MitsubaDialect, IsToldApartByContent) {
  const auto is = [](const std::string& text) {
    Diagnostics sink;
    const XmlDocument document(text, "s.xml", sink);
    return is_mitsuba(*document.root());
  };
  EXPECT_TRUE(is("<scene><sensor type=\"perspective\"/></scene>"));
  EXPECT_TRUE(is("<scene version=\"0.6.0\"/>"));
  EXPECT_TRUE(is("<scene><include filename=\"a.xml\"/></scene>"));
  EXPECT_TRUE(is("<scene><default name=\"spp\" value=\"4\"/></scene>"));
  EXPECT_FALSE(is("<scene><camera type=\"perspective\"/><shape type=\"obj\"/></scene>"));
  EXPECT_FALSE(is("<scene version=\"1\"><camera type=\"perspective\"/></scene>"));
  EXPECT_FALSE(is("<scene/>"));
  EXPECT_FALSE(is("<test type=\"ttest\"/>"));
}

TEST(MitsubaDialect, TheDoorReadsBoth) {
  const TemporaryFolder folder;
  const std::string mitsuba = folder.write("m.xml", around("<shape type=\"sphere\"/>"));
  const std::string nori = folder.write("n.xml", scene_around("<mesh type=\"sphere\"/>"));
  for (const auto& [path, is_foreign] : {std::pair{mitsuba, true}, {nori, false}}) {
    Diagnostics diagnostics;
    const auto file = read_scene_file(path, {}, diagnostics);
    ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
    EXPECT_EQ(std::get<Scene>(*file).instances.size(), 1u);
    EXPECT_EQ(all_messages(diagnostics).find("Mitsuba 3.0.0") != std::string::npos, is_foreign);
  }
}

TEST(MitsubaDialect, NamesOfAllVersions) {
  EXPECT_EQ(snake_case("toWorld"), "to_world");
  EXPECT_EQ(snake_case("intIOR"), "int_ior");
  EXPECT_EQ(snake_case("rrDepth"), "rr_depth");
  EXPECT_EQ(snake_case("alphaU"), "alpha_u");
  EXPECT_EQ(snake_case("near_clip"), "near_clip");
  EXPECT_EQ(snake_case("A"), "A");
  const Camera camera = camera_of("<sensor type=\"perspective\"><float name=\"nearClip\" value=\"2\"/></sensor>");
  EXPECT_EQ(camera.near_clip, 2.0);
}

TEST(MitsubaColors, Reflectances) {
  EXPECT_EQ(albedo_of(""), glm::dvec3(0.5));
  EXPECT_EQ(albedo_of("<rgb name=\"reflectance\" value=\"0.2 0.4,0.6\"/>"), glm::dvec3(0.2, 0.4, 0.6));
  EXPECT_EQ(albedo_of("<rgb name=\"reflectance\" value=\"0.2\"/>"), glm::dvec3(0.2));
  EXPECT_EQ(albedo_of("<float name=\"reflectance\" value=\"0.7\"/>"), glm::dvec3(0.7));
  EXPECT_EQ(albedo_of("<spectrum name=\"reflectance\" value=\"0.3\"/>"), glm::dvec3(0.3));
  expect_color(albedo_of("<spectrum name=\"reflectance\" value=\"400:0.343, 500:0.445, 600:0.551, 700:0.624\"/>"),
               {0.586333, 0.490798, 0.382672});
  expect_color(albedo_of("<spectrum name=\"reflectance\" value=\"400:0.78, 500:0.78, 600:0.78, 700:0.78\"/>"),
               {0.776367, 0.77981, 0.776029});
  // Outside what a screen can show the nearest colour is taken.
  expect_color(albedo_of("<spectrum name=\"reflectance\" value=\"400:0, 500:1, 600:3, 700:3\"/>"), {1, 1, 0.341214});
  expect_color(albedo_of("<spectrum name=\"reflectance\" value=\"450:1, 550:0\"/>"), {0, 0.176652, 0.495306});
  // Mitsuba 0.6: the encoding of sRGB.
  expect_color(albedo_of("<srgb name=\"reflectance\" value=\"#ff8000\"/>"), {1, 0.2158605, 0}, 1e-6);
  expect_color(albedo_of("<srgb name=\"reflectance\" value=\"1, 0.5, 0.04\"/>"), {1, 0.2140411, 0.04 / 12.92}, 1e-6);
}

TEST(MitsubaColors, Emission) {
  EXPECT_EQ(radiance_of(""), glm::dvec3(1.0));
  EXPECT_EQ(radiance_of("<rgb name=\"radiance\" value=\"2 4 6\"/>"), glm::dvec3(2, 4, 6));
  EXPECT_EQ(radiance_of("<float name=\"radiance\" value=\"3\"/>"), glm::dvec3(3.0));
  // Equal energy at all wavelengths is not white.
  expect_color(radiance_of("<spectrum name=\"radiance\" value=\"3\"/>"), {3.61438, 2.84487, 2.72675});
  expect_color(radiance_of("<spectrum name=\"radiance\" value=\"400:0, 500:8, 600:15.6, 700:18.4\"/>"),
               {20.7108, 10.8546, 2.77115});
  expect_color(radiance_of("<spectrum name=\"radiance\" value=\"300:3, 900:3\"/>"), {3.61465, 2.84468, 2.7278});
}

TEST(MitsubaColors, SpectraOfThreeSamplesAreOfOldScenes) {
  const auto text = [](const char* version) {
    return fmt::format(R"(<scene version="{}">{}<shape type="sphere">
    <bsdf type="diffuse"><spectrum name="reflectance" value=".9 .7 .5"/></bsdf>
    <emitter type="area"><spectrum name="radiance" value="1704, 1852, 1950"/></emitter></shape></scene>)",
                       version, kSensor);
  };
  const Read old = read(text("0.6.0"));
  ASSERT_TRUE(old.scene.has_value()) << old.messages();
  EXPECT_EQ(std::get<DiffuseBsdf>(old.scene->materials.at(0).bsdf).albedo.value, glm::dvec3(0.9, 0.7, 0.5));
  EXPECT_EQ(old.scene->emitters.at(0).radiance.value, glm::dvec3(1704, 1852, 1950));
  EXPECT_NE(read(text("3.0.0")).first_error().find("three numbers are an <rgb>"), std::string::npos);
}

TEST(MitsubaColors, SpectraWithATypeAndInFiles) {
  const auto typed = [](const std::string& type, const std::string& properties) {
    return fmt::format("<spectrum name=\"radiance\" type=\"{}\">{}</spectrum>", type, properties);
  };
  // D65 and what is uniform are grey where colours are RGB, also as emission.
  expect_color(radiance_of(typed("uniform", "<float name=\"value\" value=\"0.5\"/>")), glm::dvec3(0.5));
  expect_color(radiance_of(typed("d65", "<float name=\"scale\" value=\"3\"/>")), glm::dvec3(3.0));
  expect_color(radiance_of(typed("d65", "")), glm::dvec3(1.0));
  expect_color(radiance_of(typed("rgb", "<rgb name=\"value\" value=\"3,2,1\"/>")), {3, 2, 1});
  expect_color(radiance_of(typed("srgb", "<rgb name=\"color\" value=\"0.3,0.2,0.1\"/>")), {0.3, 0.2, 0.1});
  const glm::dvec3 listed(0.5266131, 0.22182667, 0.12312101);  // of 400:0.1, 500:0.2, 600:0.3, 700:0.9
  const std::string values = "<string name=\"values\" value=\"0.1,0.2,0.3,0.9\"/>";
  expect_color(radiance_of(typed("regular",
                                 "<float name=\"wavelengthMin\" value=\"400\"/><float "
                                 "name=\"wavelength_max\" value=\"700\"/>" +
                                     values)),
               listed);
  expect_color(radiance_of(typed("irregular", "<string name=\"wavelengths\" value=\"400,500,600,700\"/>" + values)),
               listed);
  const std::string text = around(
      "<shape type=\"sphere\"><emitter type=\"area\"><spectrum name=\"radiance\" filename=\"a.spd\"/>"
      "</emitter></shape>");
  const Read result = read(text, {}, {{"a.spd", "# nm, value\n400 0.1\n\n500, 0.2 # two\r\n600 0.3\n700 0.9"}});
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  expect_color(result.scene->emitters.at(0).radiance.value, listed);
  EXPECT_EQ(read(text, {}, {{"a.spd", "400 0.1\n300 0.2"}}).first_error().find("s.xml:2:"), 0u);
  const std::string wrong = read(text, {}, {{"a.spd", "400 0.1\n500"}}).first_error();
  EXPECT_NE(wrong.find("a.spd:2: expected a wavelength and a value, found 1"), std::string::npos) << wrong;
  EXPECT_NE(read(text).first_error().find("a.spd: no such file"), std::string::npos);
  EXPECT_FALSE(
      read(around("<shape type=\"sphere\"><emitter type=\"area\">" +
                  typed("irregular", "<string name=\"wavelengths\" value=\"400\"/>" + values) + "</emitter></shape>"))
          .scene.has_value());
}

TEST(MitsubaColors, Metals) {
  const auto metal = [](const std::string& properties) {
    return std::get<ConductorBsdf>(bsdf_of("<bsdf type=\"conductor\">" + properties + "</bsdf>"));
  };
  EXPECT_EQ(metal("").index.eta.value, glm::dvec3(0.0));
  EXPECT_EQ(metal("").index.k.value, glm::dvec3(1.0));
  expect_color(metal("<string name=\"material\" value=\"Au\"/>").index.eta.value, {0.143036, 0.375307, 1.44205});
  const ConductorBsdf given =
      metal("<spectrum name=\"eta\" value=\"400:0.789, 700:0.789\"/><rgb name=\"k\" value=\"6.15 1 2\"/>");
  expect_color(given.index.eta.value, {0.785325, 0.788808, 0.784983});
  EXPECT_EQ(given.index.k.value, glm::dvec3(6.15, 1, 2));
  const Bsdf rough = bsdf_of(R"(<bsdf type="roughconductor"><string name="material" value="Al"/>
    <string name="distribution" value="ggx"/><float name="alpha_u" value="0.25"/><float name="alpha_v" value="0.05"/>
    </bsdf>)");
  const Roughness& roughness = std::get<RoughConductorBsdf>(rough).roughness;
  EXPECT_EQ(roughness.distribution, Roughness::Distribution::ggx);
  EXPECT_EQ(roughness.alpha_u.value, 0.25);
  EXPECT_EQ(roughness.alpha_v.value, 0.05);
}

TEST(MitsubaColors, WhatIsWrongHasItsPlace) {
  const auto error = [](const std::string& reflectance) {
    return read(around("<shape type=\"sphere\"><bsdf type=\"diffuse\">" + reflectance + "</bsdf></shape>"))
        .first_error();
  };
  EXPECT_EQ(error("<rgb name=\"reflectance\" value=\"1 2\"/>").substr(0, 11), "s.xml:2:74:");
  EXPECT_NE(error("<rgb name=\"reflectance\" value=\"0.5 -1 0\"/>").find("-1 is out of range"), std::string::npos);
  EXPECT_NE(error("<spectrum name=\"reflectance\" value=\"500:1\"/>").find("at least two pairs"), std::string::npos);
  EXPECT_NE(error("<spectrum name=\"reflectance\" value=\"500:1, 400:1\"/>").find("400 does not come after 500"),
            std::string::npos);
  EXPECT_NE(error("<point name=\"reflectance\" value=\"1 1 1\"/>").find("<point> is not a colour"), std::string::npos);
}

TEST(MitsubaSensor, Defaults) {
  const Read result = read(with_sensor("<sensor type=\"perspective\"/>"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Camera& camera = result.scene->camera;
  EXPECT_EQ(camera.width, 768u);
  EXPECT_EQ(camera.height, 576u);
  EXPECT_NEAR(fov_across(camera), 38.18484, 1e-4);
  EXPECT_EQ(camera.near_clip, 0.01);
  EXPECT_EQ(camera.far_clip, 10000.0);
  EXPECT_EQ(camera.filter.type, ReconstructionFilter::Type::gaussian);
  EXPECT_EQ(camera.filter.stddev, 0.5);
  EXPECT_EQ(camera.filter.radius, 2.0);
  EXPECT_EQ(result.scene->sampler.sample_count, 4u);
  EXPECT_EQ(result.scene->integrator.type, Integrator::Type::path);
  EXPECT_EQ(result.scene->integrator.max_depth, Integrator::kUnlimitedDepth);
  EXPECT_EQ(result.scene->integrator.rr_depth, 5u);
}

TEST(MitsubaSensor, TheCallerMayPlaceWhatAFileLacks) {
  const std::string text = "<scene version=\"3.0.0\"><shape type=\"sphere\"/></scene>";
  EXPECT_NE(read(text).first_error().find("needs a <sensor>; add one, or place a camera by --camera"),
            std::string::npos);
  ReadOptions options;
  options.camera = "0 0 5 0 0 0";
  const Read placed = read(text, options);
  ASSERT_TRUE(placed.scene.has_value()) << placed.messages();
  EXPECT_EQ(placed.scene->camera.width, 768u);
  EXPECT_EQ(placed.scene->camera.filter.type, ReconstructionFilter::Type::gaussian);
  EXPECT_EQ(placed.scene->sampler.sample_count, 4u);
}

TEST(MitsubaSensor, FieldsOfView) {
  const auto fov = [](const std::string& properties) {
    return fov_across(
        camera_of("<sensor type=\"perspective\">" + properties +
                  "<film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" "
                  "value=\"100\"/></film></sensor>"));
  };
  const std::string forty = "<float name=\"fov\" value=\"40\"/>";
  const auto along = [&](const char* axis) {
    return fmt::format("{}<string name=\"fov_axis\" value=\"{}\"/>", forty, axis);
  };
  EXPECT_NEAR(fov(""), 42.311714, 1e-4);
  EXPECT_NEAR(fov("<string name=\"focal_length\" value=\"35mm\"/>"), 57.871193, 1e-4);
  EXPECT_NEAR(fov(forty), 40.0, 1e-9);
  EXPECT_NEAR(fov(along("x")), 40.0, 1e-9);
  EXPECT_NEAR(fov(along("y")), 72.104774, 1e-4);
  EXPECT_NEAR(fov(along("smaller")), 72.104774, 1e-4);
  EXPECT_NEAR(fov(along("larger")), 40.0, 1e-9);
  EXPECT_NEAR(fov(along("diagonal")), 36.064789, 1e-4);
}

TEST(MitsubaSensor, FiltersAndSamplers) {
  const auto scene = [](const std::string& rfilter, const std::string& sampler) {
    Read result = read(with_sensor("<sensor type=\"perspective\"><film type=\"hdrfilm\">" + rfilter + "</film>" +
                                   sampler + "</sensor>"));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    return result.scene.value_or(Scene{});
  };
  EXPECT_EQ(scene("<rfilter type=\"box\"/>", "").camera.filter.type, ReconstructionFilter::Type::box);
  EXPECT_EQ(scene("<rfilter type=\"tent\"/>", "").camera.filter.type, ReconstructionFilter::Type::tent);
  EXPECT_EQ(scene("<rfilter type=\"tent\"><float name=\"radius\" value=\"2.5\"/></rfilter>", "").camera.filter.stretch,
            2.5);
  EXPECT_EQ(scene("<rfilter type=\"box\"><float name=\"radius\" value=\"1.5\"/></rfilter>", "").camera.filter.stretch,
            3.0);
  EXPECT_EQ(scene("<rfilter type=\"lanczos\"/>", "").camera.filter.lobes, 3u);
  const ReconstructionFilter sharp =
      scene("<rfilter type=\"lanczos\"><integer name=\"lobes\" value=\"2\"/></rfilter>", "").camera.filter;
  EXPECT_EQ(sharp.type, ReconstructionFilter::Type::lanczos);
  EXPECT_EQ(sharp.lobes, 2u);
  const ReconstructionFilter catmull = scene("<rfilter type=\"catmullrom\"/>", "").camera.filter;
  EXPECT_EQ(catmull.b, 0.0);
  EXPECT_EQ(catmull.c, 0.5);
  const ReconstructionFilter wide =
      scene("<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"0.8\"/></rfilter>", "").camera.filter;
  EXPECT_DOUBLE_EQ(wide.radius, 3.2);
  const Sampler spread =
      scene("", "<sampler type=\"multijitter\"><integer name=\"sample_count\" value=\"64\"/></sampler>").sampler;
  EXPECT_EQ(spread.type, Sampler::Type::sobol);
  EXPECT_EQ(spread.sample_count, 64u);
  for (const char* type : {"bose", "bush"})
    EXPECT_EQ(scene("", fmt::format("<sampler type=\"{}\"/>", type)).sampler.type, Sampler::Type::sobol) << type;
}

TEST(MitsubaTransforms, ApplyInTheOrderListed) {
  const Read result = read(around(R"(<shape type="rectangle"><transform name="to_world">
    <rotate x="1" angle="30"/><scale x="2"/><translate value="1 2 3"/></transform></shape>)"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const glm::dmat4& m = result.scene->instances.at(0).world_from_object;
  const double c = std::sqrt(0.75);  // Mitsuba: [2, 0, 0, 0], [0, 0.866025, -0.5, 0], [0, 0.5, 0.866025, 0]
  const glm::dmat4 expected = {{2, 0, 0, 0}, {0, c, 0.5, 0}, {0, -0.5, c, 0}, {1, 2, 3, 1}};
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(m[i / 4][i % 4], expected[i / 4][i % 4], 1e-12) << i;
}

TEST(MitsubaTransforms, LookAlongZWithXToTheLeft) {
  const Camera camera = camera_of(R"(<sensor type="perspective"><transform name="toWorld">
    <lookAt origin="1, 0, 0" target="1, 0, 5" up="0, 1, 0"/></transform></sensor>)");
  EXPECT_EQ(camera.world_from_camera[0], glm::dvec4(1, 0, 0, 0));
  EXPECT_EQ(camera.world_from_camera[2], glm::dvec4(0, 0, 1, 0));
  EXPECT_EQ(camera.world_from_camera[3], glm::dvec4(1, 0, 0, 1));
}

TEST(MitsubaTransforms, Matrices) {
  const Read nine = read(around(R"(<shape type="rectangle"><transform name="to_world">
    <matrix value="1 2 3 4 5 6 7 8 10"/></transform></shape>)"));
  ASSERT_TRUE(nine.scene.has_value()) << nine.messages();
  EXPECT_EQ(nine.scene->instances[0].world_from_object[1], glm::dvec4(2, 5, 8, 0));
  for (const char* wrong : {"<matrix value=\"1 2 3\"/>", "<lookat origin=\"0 0 0\" target=\"0 0 0\" up=\"0 1 0\"/>",
                            "<lookat origin=\"0 0 0\" target=\"0 1 0\" up=\"0 1 0\"/>", "<rotate angle=\"5\"/>",
                            "<shear value=\"1\"/>", "<scale value=\"1 2\"/>", "<translate x=\"one\"/>"}) {
    const Read result = read(
        around("<shape type=\"cube\"><transform name=\"to_world\">" + std::string(wrong) + "</transform></shape>"));
    EXPECT_FALSE(result.scene.has_value()) << wrong;
    EXPECT_EQ(result.first_error().find("s.xml:2:"), 0u) << result.messages();
  }
}

// Many files give matrices with four to six digits; this one turns the sky of Mitsuba's own preview of materials.
TEST(MitsubaTransforms, MatricesOfFewDigitsTurnSkiesLightsAndSpheres) {
  const char* matrix =
      R"(<transform name="to_world"><matrix value="-0.224951 -0.000001 -0.974370 0 -0.974370 0 0.224951 0
      0 1 -0.000001 8.87 0 0 0 1"/></transform>)";
  const Read result = read(around(fmt::format(
      R"(<shape type="sphere">{0}</shape><emitter type="envmap">{1}{0}</emitter><emitter type="spot">{0}</emitter>)",
      matrix, kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const glm::dmat3 written = {-0.224951, -0.974370, 0, -0.000001, 0, 1, -0.974370, 0.224951, -0.000001};
  for (const glm::dmat3& m :
       {result.scene->sky.world_from_sky, glm::dmat3(result.scene->delta_lights.at(0).world_from_light),
        glm::dmat3(result.scene->instances.at(0).world_from_object)}) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_LT(glm::distance(m[a], written[a]), 2e-6) << a;
      EXPECT_NEAR(glm::dot(m[a], m[(a + 1) % 3]), 0.0, 1e-14) << a;
      EXPECT_NEAR(glm::length(m[a]), glm::length(m[0]), 1e-14) << a;
    }
  }
  EXPECT_EQ(result.scene->instances.at(0).world_from_object[3], glm::dvec4(0, 0, 8.87, 1));
}

TEST(MitsubaTransforms, UnevenScalesStayErrors) {
  const Read result =
      read(around(R"(<shape type="sphere"><transform name="to_world"><scale value="1 1.001 1"/></transform></shape>)"));
  EXPECT_NE(result.first_error().find("scales it unevenly"), std::string::npos) << result.messages();
}

TEST(MitsubaParameters, DefaultsAndTheCommandLine) {
  const std::string text =
      "<scene version=\"3.0.0\"><default name=\"w\" value=\"40\"/><default name=\"width\" value=\"320\"/><default "
      "name=\"width\" value=\"9\"/><sensor type=\"perspective\"><float name=\"fov\" value=\"$w\"/><film "
      "type=\"hdrfilm\"><integer name=\"width\" value=\"$width\"/></film></sensor><shape type=\"sphere\"/></scene>";
  const Read plain = read(text);
  ASSERT_TRUE(plain.scene.has_value()) << plain.messages();
  EXPECT_EQ(plain.scene->camera.width, 320u);  // the longest name that fits, the first default
  EXPECT_EQ(plain.scene->camera.fov, 40.0);
  const Read defined = read(text, {.overrides = {{"width", "64"}}});
  ASSERT_TRUE(defined.scene.has_value()) << defined.messages();
  EXPECT_EQ(defined.scene->camera.width, 64u);
  const Read unknown = read(text, {.overrides = {{"with", "64"}}});
  EXPECT_NE(unknown.first_error().find("did you mean \"width\""), std::string::npos) << unknown.messages();
  EXPECT_EQ(unknown.diagnostics.list().back().kind, ErrorKind::usage);
  const Read missing = read(around("<shape type=\"sphere\"><float name=\"radius\" value=\"$r\"/></shape>"));
  EXPECT_NE(missing.first_error().find("s.xml:2:50: the parameter $r has no value"), std::string::npos)
      << missing.messages();
}

TEST(MitsubaParameters, LaughsEndSoon) {
  std::string text = "<scene version=\"3.0.0\"><default name=\"a0\" value=\"ha ha ha ha \"/>";
  for (int i = 1; i < 60; ++i)
    text += fmt::format("<default name=\"a{}\" value=\"$a{}$a{}$a{}\"/>", i, i - 1, i - 1, i - 1);
  const Read result = read(text + kSensor + std::string("<shape type=\"sphere\"/></scene>"));
  EXPECT_FALSE(result.scene.has_value());
  EXPECT_NE(result.first_error().find("bytes"), std::string::npos) << result.messages();
  EXPECT_EQ(result.diagnostics.error_count(), 1u);
}

TEST(MitsubaIncludes, StandWhereTheyAreNamed) {
  const Files files = {{"a.xml",
                        "<scene version=\"3.0.0\">\n<bsdf type=\"diffuse\" id=\"red\"><rgb name=\"reflectance\" "
                        "value=\"$r 0 0\"/></bsdf></scene>"},
                       {"b.xml", "<shape type=\"sphere\"><ref id=\"red\"/></shape>"}};
  const Read result = read(around("<default name=\"r\" value=\"0.25\"/><include filename=\"a.xml\"/><include "
                                  "filename=\"b.xml\"/>"),
                           {}, files);
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  EXPECT_EQ(std::get<DiffuseBsdf>(result.scene->materials.at(0).bsdf).albedo.value, glm::dvec3(0.25, 0, 0));
  EXPECT_EQ(to_string(result.scene->materials[0].position), "a.xml:2:1");
  EXPECT_EQ(to_string(result.scene->instances.at(0).position), "b.xml:1:1");
}

TEST(MitsubaIncludes, ErrorsHaveThePlaceInTheirFile) {
  const Read result = read(around("<include filename=\"a.xml\"/>"), {},
                           {{"a.xml", "<scene version=\"3.0.0\">\n\n <shape type=\"sphre\"/></scene>"}});
  EXPECT_EQ(result.first_error().find("a.xml:3:15: unknown shape type \"sphre\"; did you mean \"sphere\""), 0u)
      << result.messages();
  const Read missing = read(around("<include filename=\"none.xml\"/>"));
  EXPECT_EQ(missing.first_error().find("s.xml:2:20: included file none.xml: no such file"), 0u) << missing.messages();
}

TEST(MitsubaIncludes, CirclesAndFloodsEnd) {
  const std::string a = "<scene version=\"3.0.0\"><include filename=\"b.xml\"/></scene>";
  const std::string b = "<scene version=\"3.0.0\"><include filename=\"a.xml\"/></scene>";
  const Read circle = read(around("<include filename=\"a.xml\"/>"), {}, {{"a.xml", a}, {"b.xml", b}});
  EXPECT_NE(circle.first_error().find("b.xml:1:"), std::string::npos) << circle.messages();
  EXPECT_NE(circle.first_error().find("includes itself"), std::string::npos) << circle.messages();
  const Read itself = read(around("<include filename=\"s.xml\"/>"), {}, {{"s.xml", around("")}});
  EXPECT_NE(itself.first_error().find("includes itself"), std::string::npos) << itself.messages();
  Files doubling, chain;
  for (int i = 0; i < 40; ++i) {
    const std::string include = fmt::format("<include filename=\"f{}.xml\"/>", i + 1);
    doubling[fmt::format("f{}.xml", i)] = "<scene version=\"3.0.0\">" + (i < 14 ? include + include : "") + "</scene>";
    chain[fmt::format("f{}.xml", i)] = "<scene version=\"3.0.0\">" + include + "</scene>";
  }
  const Read flood = read(around("<include filename=\"f0.xml\"/>"), {}, doubling);
  EXPECT_NE(flood.first_error().find("more than 1000 files"), std::string::npos) << flood.messages();
  EXPECT_EQ(flood.diagnostics.error_count(), 1u) << flood.messages();
  const Read deep = read(around("<include filename=\"f0.xml\"/>"), {}, chain);
  EXPECT_NE(deep.first_error().find("at most 15 are supported"), std::string::npos) << deep.messages();
}

TEST(MitsubaReferences, IdsAliasesAndNames) {
  const Read result = read(around(R"(<bsdf type="diffuse" id="a"/><alias id="a" as="b"/>
    <emitter type="area" id="lamp"><rgb name="radiance" value="3"/></emitter>
    <shape type="sphere"><ref id="a"/></shape><shape type="sphere"><ref name="bsdf" id="b"/><ref id="lamp"/></shape>)"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  EXPECT_EQ(result.scene->instances.at(0).material, result.scene->instances.at(1).material);
  EXPECT_EQ(result.scene->materials.size(), 1u);
  EXPECT_EQ(result.scene->emitters.at(0).radiance.value, glm::dvec3(3.0));
  const Read unknown =
      read(around("<bsdf type=\"diffuse\" id=\"wood\"/><shape type=\"sphere\"><ref id=\"woood\"/></shape>"));
  EXPECT_NE(unknown.first_error().find("did you mean \"wood\""), std::string::npos) << unknown.messages();
  const Read twice = read(around("<bsdf type=\"diffuse\" id=\"a\"/><bsdf type=\"diffuse\" id=\"a\"/>"));
  EXPECT_NE(twice.first_error().find("the id \"a\" is given twice"), std::string::npos) << twice.messages();
  const Read loop = read(around("<integrator type=\"moment\" id=\"i\"><ref id=\"i\"/></integrator>"));
  EXPECT_NE(loop.first_error().find("integrators are nested"), std::string::npos) << loop.messages();
}

TEST(MitsubaShapes, DefaultMaterials) {
  const Read result = read(around("<shape type=\"sphere\"/><shape type=\"sphere\"><emitter type=\"area\"/></shape>"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.bsdf_of(scene.instances.at(0))).albedo.value, glm::dvec3(0.5));
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.bsdf_of(scene.instances.at(1))).albedo.value, glm::dvec3(0.0));
}

TEST(MitsubaShapes, MeshesAreSmoothUnlessTheyAreFlat) {
  const std::string file = "<string name=\"filename\" value=\"m.obj\"/>";
  const Read result = read(around("<shape type=\"obj\">" + file + "</shape><shape type=\"obj\">" + file +
                                  "<boolean name=\"face_normals\" value=\"true\"/></shape><shape type=\"obj\">" + file +
                                  "<boolean name=\"flipNormals\" value=\"true\"/></shape>"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  ASSERT_EQ(scene.instances.size(), 3u);
  const auto mesh = [&](std::size_t i) { return std::get<TriangleMesh>(scene.shape_of(scene.instances[i])); };
  EXPECT_EQ(mesh(0).normals.size(), 3u);
  EXPECT_EQ(mesh(0).normals[0], glm::dvec3(0, 0, 1));
  EXPECT_TRUE(mesh(1).normals.empty());
  EXPECT_EQ(scene.instances[0].shape, scene.instances[2].shape);  // one file is read once
  EXPECT_TRUE(scene.instances[2].flip_normals);
}

// As in Mitsuba 3.9.1, whose meshes from such a file have vertex normals; 0.6 follows the file.
TEST(MitsubaShapes, FilesThatWantFlatTrianglesGetThemIn06) {
  const auto is_flat = [](const char* version) {
    Diagnostics diagnostics;
    const std::string text = fmt::format(
        R"(<scene version="{}">{}<shape type="serialized"><string name="filename" value="m"/></shape></scene>)",
        version, kSensor);
    auto document = std::make_unique<XmlDocument>(text, "s.xml", diagnostics);
    const auto load = [](const std::string& path, std::int64_t, Diagnostics& sink) -> std::optional<SerializedMesh> {
      return SerializedMesh{.mesh = load_triangle(mesh_formats()[0], path, {}, sink).value(), .face_normals = true};
    };
    const auto scene = parse_mitsuba_scene(std::move(document), {}, {load_triangle, {}, load, {}}, diagnostics);
    EXPECT_TRUE(scene.has_value()) << all_messages(diagnostics);
    return scene && std::get<TriangleMesh>(scene->shape_of(scene->instances.at(0))).normals.empty();
  };
  EXPECT_TRUE(is_flat("0.6.0"));
  EXPECT_FALSE(is_flat("3.0.0"));
}

TEST(MitsubaShapes, RectanglesAndCubesPointOutward) {
  const Read result = read(around("<shape type=\"rectangle\"/><shape type=\"cube\"/>"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  for (const Instance& instance : result.scene->instances) {
    const auto& mesh = std::get<TriangleMesh>(result.scene->shape_of(instance));
    double area = 0.0;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 p = mesh.positions[t.x];
      const glm::dvec3 cross = glm::cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p);
      area += 0.5 * glm::length(cross);
      EXPECT_TRUE(mesh.normals.empty());  // flat, by the winding
      EXPECT_GE(glm::dot(cross, p), 0.0);
    }
    EXPECT_EQ(area, mesh.triangles.size() == 2 ? 4.0 : 24.0);
  }
}

// The sides are those on which Mitsuba 3.9.1 reflects and emits: those of its shading normals.
TEST(MitsubaShapes, WhatMirrorsTurnInsideOut) {
  const auto flipped = [](const char* type, const char* scale) {
    const Read result = read(around(fmt::format(
        "<shape type=\"{}\"><transform name=\"to_world\"><scale value=\"{}\"/></transform></shape>", type, scale)));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    return result.scene.has_value() && result.scene->instances.at(0).flip_normals;
  };
  EXPECT_FALSE(flipped("sphere", "1 1 1"));
  for (const char* scale : {"-1 1 1", "1 -1 1", "1 1 -1", "-1 -1 -1"}) EXPECT_TRUE(flipped("sphere", scale));
  EXPECT_FALSE(flipped("sphere", "-1 -1 1"));
  for (const char* type : {"rectangle", "cube", "disk", "cylinder"}) {
    for (const char* scale : {"1 1 1", "-1 1 1", "1 1 -1", "-1 -1 -1"}) EXPECT_FALSE(flipped(type, scale)) << type;
  }
}

TEST(MitsubaIntegrator, WordsOf06WithoutEffectAreKnown) {
  const Read result =
      read(fmt::format(
               "<scene version=\"0.6.0\">{}<integrator type=\"path\"><boolean name=\"strictNormals\" value=\"true\"/>"
               "</integrator><shape type=\"sphere\"/></scene>",
               kSensor),
           {.strict = true});
  EXPECT_TRUE(result.scene.has_value()) << result.messages();
  EXPECT_NE(result.messages().find("has no effect"), std::string::npos) << result.messages();
}

// Mitsuba 3.9.1 prints this matrix for a rectangle with that rotation.
TEST(MitsubaTransform, AxesOfRotationsCountWithTheirLength) {
  const std::string turn = R"(<transform name="to_world"><rotate x="1" y="1" angle="40"/></transform>)";
  const auto placed = [&](const std::string& shape, const char* version = "3.0.0") {
    const Read result = read(fmt::format("<scene version=\"{}\">{}{}</scene>", version, kSensor, shape));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    EXPECT_EQ(result.messages().find("has length 1.414") != std::string::npos, std::string(version) != "0.6.0");
    return result.scene ? glm::dmat3(result.scene->instances.at(0).world_from_object) : glm::dmat3(0.0);
  };
  const auto near = [](const glm::dmat3& a, const glm::dmat3& b) {
    for (int column = 0; column < 3; ++column) EXPECT_LT(glm::distance(a[column], b[column]), 2e-6);
  };
  const glm::dmat3 in_mitsuba(1.0, 0.233956, -0.642788, 0.233956, 1.0, 0.642788, 0.642788, -0.642788, 0.766044);
  const glm::dmat3 rotation(0.8830222, 0.1169778, -0.4545195, 0.1169778, 0.8830222, 0.4545195, 0.4545195, -0.4545195,
                            0.7660444);
  near(placed("<shape type=\"rectangle\">" + turn + "</shape>"), in_mitsuba);
  near(placed("<shape type=\"rectangle\">" + turn + "</shape>", "0.6.0"), rotation);
  near(placed("<shape type=\"sphere\">" + turn + "</shape>"), rotation);
  const std::string group = "<shape type=\"instance\">" + turn + "<shape type=\"shapegroup\"><shape type=\"";
  near(placed(group + "cube\"/></shape></shape>"), in_mitsuba);
  near(placed(group + "sphere\"/></shape></shape>"), rotation);
}

TEST(MitsubaShapes, GroupsAreShownWhereTheirInstancesAre) {
  const Read result = read(around(R"(<shape type="shapegroup" id="g">
    <shape type="sphere"><transform name="to_world"><translate x="1"/></transform></shape><shape type="rectangle"/></shape>
    <shape type="instance"><ref id="g"/></shape>
    <shape type="instance"><ref id="g"/><transform name="to_world"><scale value="2"/><translate z="5"/></transform></shape>)"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.shapes.size(), 2u);
  EXPECT_EQ(scene.instances[0].world_from_object[3], glm::dvec4(1, 0, 0, 1));
  EXPECT_EQ(scene.instances[2].world_from_object[3], glm::dvec4(2, 0, 5, 1));
  const Read nested =
      read(around(R"(<shape type="shapegroup" id="g"><shape type="instance"><ref id="g"/></shape></shape>
    <shape type="instance"><ref id="g"/></shape>)"));
  EXPECT_NE(nested.first_error().find("cannot hold groups or instances"), std::string::npos) << nested.messages();
}

TEST(MitsubaShapes, ManyAreRead) {
  std::string text = "<bsdf type=\"diffuse\" id=\"a\"/>";
  for (int i = 0; i < 100'000; ++i)
    text += fmt::format(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><translate x=\"{}\"/></transform><ref "
        "id=\"a\"/></shape>\n",
        i);
  const Read result = read(around(text));
  ASSERT_TRUE(result.scene.has_value()) << result.messages().substr(0, 1000);
  EXPECT_EQ(result.scene->instances.size(), 100'000u);
  EXPECT_EQ(result.scene->shapes.size(), 1u);
}

TEST(MitsubaIntegrators, DepthsAndNames) {
  const auto integrator = [](const std::string& xml) {
    const Read result = read(around(xml + "<shape type=\"sphere\"/>"));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    return result.scene ? result.scene->integrator : Integrator{};
  };
  EXPECT_EQ(integrator("<integrator type=\"path\"><integer name=\"max_depth\" value=\"2\"/></integrator>").max_depth,
            2u);
  const Integrator wrapped = integrator(R"(<integrator type="moment"><integrator type="path">
    <integer name="maxDepth" value="3"/><boolean name="hide_emitters" value="true"/></integrator></integrator>)");
  EXPECT_EQ(wrapped.max_depth, 3u);
  EXPECT_TRUE(wrapped.hide_emitters);
  const Integrator direct = integrator(R"(<integrator type="direct"><integer name="shading_samples" value="3"/>
    <integer name="bsdf_samples" value="2"/></integrator>)");
  EXPECT_EQ(direct.type, Integrator::Type::direct);
  EXPECT_EQ(direct.emitter_samples, 3u);
  EXPECT_EQ(direct.bsdf_samples, 2u);
  EXPECT_EQ(integrator("<integrator type=\"ptracer\"/>").type, Integrator::Type::path);
}

/// "shape_index" is our instance, names of channels are not kept; what we do not have is one of the missing things.
TEST(MitsubaIntegrators, AovsAreThoseBesideThePicture) {
  const auto text = [](const char* list) {
    return around(fmt::format(R"(<integrator type="aov"><string name="aovs" value="{}"/><integrator type="path"/>
      </integrator><shape type="sphere"/>)",
                              list));
  };
  const Read result = read(text("dd.y:depth,nn:sh_normal,i:shape_index,gn:geo_normal,a:albedo,uv:uv,pp:position"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  EXPECT_EQ(result.scene->aovs, (std::vector{Aov::depth, Aov::shading_normal, Aov::instance, Aov::geometric_normal,
                                             Aov::albedo, Aov::uv, Aov::position}));
  EXPECT_FALSE(read(text("t:dp_du")).scene.has_value());
  const Read approximated = read(text("t:dp_du,d:depth"), {.overrides = {}, .approximate = true});
  ASSERT_TRUE(approximated.scene.has_value()) << approximated.messages();
  EXPECT_EQ(approximated.scene->aovs, std::vector{Aov::depth});
  EXPECT_NE(approximated.messages().find("aov t:dp_du is approximated: left out"), std::string::npos);
}

/// The brightest direction of the sky, in the world.
glm::dvec3 brightest(const Sky& sky) {
  const Bitmap& picture = *sky.picture->bitmap;
  float most = 0.0f;
  glm::dvec3 found(0.0);
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    for (std::uint32_t x = 0; x < picture.width; ++x) {
      if (picture.stored(x, y, 1) <= most) continue;
      most = picture.stored(x, y, 1);
      const double phi = 2.0 * std::numbers::pi * (x + 0.5) / picture.width;
      const double theta = std::numbers::pi * (y + 0.5) / picture.height;
      found = {std::sin(phi) * std::sin(theta), std::cos(theta), -std::cos(phi) * std::sin(theta)};
    }
  }
  return sky.world_from_sky * found;
}

/// Mitsuba 3 counts heights along z; directions by its own sun, found as the brightest of its sky.
TEST(MitsubaLights, SkiesAreApproximatedWithTheSunInItsPlace) {
  const std::string by_direction =
      around(R"(<emitter type="sunsky"><vector name="sun_direction" x="0.5" y="0" z="0.866"/>
    </emitter><shape type="sphere"/>)");
  const Read refused = read(by_direction);
  EXPECT_FALSE(refused.scene.has_value());
  EXPECT_NE(refused.first_error().find("emitter sunsky"), std::string::npos) << refused.first_error();
  const Read there = read(by_direction, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(there.scene.has_value()) << there.messages();
  EXPECT_GT(glm::dot(brightest(there.scene->sky), glm::normalize(glm::dvec3(0.5, 0.0, 0.866))), 0.99995);
  ASSERT_EQ(there.scene->approximations.size(), 1u);
  const Read by_time = read(around(R"(<emitter type="sunsky"><float name="hour" value="12"/></emitter>
    <shape type="sphere"/>)"),
                            {.overrides = {}, .approximate = true});
  ASSERT_TRUE(by_time.scene.has_value()) << by_time.messages();
  EXPECT_GT(glm::dot(brightest(by_time.scene->sky), glm::normalize(glm::dvec3(0.2359, 0.0588, 0.97))), 0.9995);
}

/// Row 0 is where Mitsuba's v is 0: there, texture coordinates of a Scene have v = 1.
TEST(MitsubaTextures, LieAsInMitsuba) {
  const auto uv = [](const std::string& texture, const glm::dvec2& of_surface) {
    const Read result = read(around("<shape type=\"sphere\"><bsdf type=\"diffuse\">" + texture + "</bsdf></shape>"));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    if (!result.scene) return glm::dvec2(-1.0);
    EXPECT_EQ(std::get<DiffuseBsdf>(result.scene->materials.at(0).bsdf).albedo.texture, 0u);
    // Mitsuba's coordinates of the surface, in ours.
    return glm::dvec2(result.scene->textures.at(0).uv_transform * glm::dvec3(of_surface.x, 1.0 - of_surface.y, 1.0));
  };
  const std::string scaled =
      R"(<transform name="to_uv"><scale x="2" y="3"/><translate x="0.5"/></transform></texture>)";
  const glm::dvec2 bitmap =
      uv(fmt::format(R"(<texture name="reflectance" type="bitmap">{}{})", kPicture, scaled), {0.1, 0.2});
  EXPECT_NEAR(bitmap.x, 0.7, 1e-12);
  EXPECT_NEAR(bitmap.y, 1.0 - 0.6, 1e-12);  // a picture's v of 1 is its first row
  const glm::dvec2 board = uv("<texture name=\"reflectance\" type=\"checkerboard\">" + scaled, {0.1, 0.2});
  EXPECT_NEAR(board.x, 0.7, 1e-12);
  EXPECT_NEAR(board.y, 0.6, 1e-12);
  const glm::dvec2 old = uv(R"(<texture name="reflectance" type="checkerboard"><float name="uscale" value="4"/>
    <float name="voffset" value="0.25"/></texture>)",
                            {0.1, 0.2});
  EXPECT_NEAR(old.x, 0.4, 1e-12);
  EXPECT_NEAR(old.y, 0.45, 1e-12);
  const glm::dvec2 both = uv(R"(<texture name="reflectance" type="checkerboard"><float name="uvscale" value="4"/>
    <float name="vscale" value="2"/></texture>)",
                             {0.1, 0.2});
  EXPECT_NEAR(both.x, 0.4, 1e-12);
  EXPECT_NEAR(both.y, 0.4, 1e-12);
}

TEST(MitsubaTextures, PropertiesAndReferences) {
  const Read result =
      read(around(fmt::format(R"(<texture id="t" type="bitmap">{0}<string name="wrap_mode" value="clamp"/>
    <string name="filter_type" value="nearest"/><boolean name="raw" value="true"/></texture>
    <texture id="u" type="bitmap">{0}</texture>
    <shape type="disk"><bsdf type="diffuse"><ref id="t" name="reflectance"/></bsdf></shape>
    <shape type="disk"><bsdf type="diffuse"><ref id="t" name="reflectance"/></bsdf></shape>
    <shape type="sphere"><emitter type="area"><texture type="scale" name="radiance"><float name="scale" value="3"/>
      <ref id="u"/></texture></emitter></shape>)",
                              kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  ASSERT_EQ(scene.textures.size(), 2u);
  EXPECT_EQ(scene.bitmaps.size(), 1u);
  const auto& bitmap = std::get<BitmapTexture>(scene.textures[0].source);
  EXPECT_EQ(bitmap.wrap_u, TextureWrap::clamp);
  EXPECT_EQ(bitmap.wrap_v, TextureWrap::clamp);
  EXPECT_EQ(bitmap.filter, TextureFilter::nearest);
  EXPECT_EQ(bitmap.color_space, ColorSpace::linear);
  EXPECT_FALSE(std::get<BitmapTexture>(scene.textures[1].source).color_space.has_value());
  EXPECT_EQ(scene.emitters.at(0).radiance.value, glm::dvec3(3.0));
  EXPECT_EQ(scene.emitters.at(0).radiance.texture, 1u);
  const Read wrong = read(around(R"(<shape type="disk"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
    <string name="filename" value="none.png"/></texture></bsdf></shape>)"));
  EXPECT_EQ(wrong.first_error().find("s.xml:3:5: picture none.png"), 0u) << wrong.messages();
}

/// Figures of Mitsuba's variant with spectra.
TEST(MitsubaColors, BlackBodiesGlowAsPlanckSays) {
  expect_color(radiance_of(R"(<spectrum name="radiance" type="blackbody"><float name="temperature" value="2700"/>
    </spectrum>)"),
               {314.52, 130.63, 31.19}, 2e-3);
  expect_color(radiance_of("<blackbody name=\"radiance\" temperature=\"5000K\" scale=\"0.5\"/>"),
               0.5 * glm::dvec3(15278.7, 12094.7, 9599.8), 2e-3);
  const Read cold = read(around(
      "<emitter type=\"constant\"><blackbody name=\"radiance\" temperature=\"5\"/></emitter><shape type=\"sphere\"/>"));
  EXPECT_NE(cold.first_error().find("a black body of 5 kelvin; use 100 to 1000000"), std::string::npos)
      << cold.messages();
}

TEST(MitsubaSensor, OfABatchTheFirstIsAnApproximation) {
  const std::string batch = with_sensor(R"(<sensor type="batch"><sensor type="thinlens">
    <float name="aperture_radius" value="0.25"/><spectrum name="srf" value="400:1, 700:0"/></sensor>
    <sensor type="orthographic"/><film type="hdrfilm"><integer name="width" value="90"/>
    <integer name="height" value="50"/></film></sensor>)");
  const Read refused = read(batch);
  EXPECT_NE(refused.first_error().find("sensor batch (s.xml"), std::string::npos) << refused.messages();
  EXPECT_NE(refused.first_error().find("response to wavelengths"), std::string::npos) << refused.messages();
  const Read there = read(batch, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(there.scene.has_value()) << there.messages();
  EXPECT_EQ(there.scene->camera.type, Camera::Type::thin_lens);
  EXPECT_EQ(there.scene->camera.width, 45u);
  EXPECT_EQ(there.scene->camera.height, 50u);
  EXPECT_EQ(there.scene->approximations.size(), 2u);
}

TEST(MitsubaBsdfs, BumpsNeedABitmap) {
  const std::string board = around(R"(<shape type="disk"><bsdf type="bumpmap"><texture type="checkerboard"/>
    <bsdf type="diffuse"/></bsdf></shape>)");
  EXPECT_NE(read(board).first_error().find("bumps of another texture than a bitmap"), std::string::npos);
  EXPECT_TRUE(read(board, {.overrides = {}, .approximate = true}).scene.has_value());
}

/// As in 0.6; a frame of black or white texels stands for what lies beyond.
TEST(MitsubaTextures, BeyondTheirEdgesPicturesMayBeBlackOrWhite) {
  const Read result = read(around(fmt::format(R"(<shape type="disk"><bsdf type="diffuse">
    <texture name="reflectance" type="bitmap">{0}<string name="wrap_mode_u" value="one"/>
    <string name="wrap_mode_v" value="mirror"/></texture></bsdf></shape><shape type="disk"><bsdf type="diffuse">
    <texture name="reflectance" type="bitmap">{0}<string name="wrap_mode" value="zero"/></texture></bsdf></shape>)",
                                              kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  ASSERT_EQ(scene.bitmaps.size(), 2u);
  const auto row_of = [](const Bitmap& picture, std::uint32_t y) {
    std::vector<float> row;
    for (std::uint32_t x = 0; x < picture.width; ++x) row.push_back(picture.stored(x, y, 0));
    return row;
  };
  EXPECT_EQ(scene.bitmaps[0]->height, 1u);
  EXPECT_EQ(row_of(*scene.bitmaps[0], 0), (std::vector<float>{1, 0, 1, 1}));
  ASSERT_EQ(scene.bitmaps[1]->height, 3u);
  EXPECT_EQ(row_of(*scene.bitmaps[1], 0), (std::vector<float>{0, 0, 0, 0}));
  EXPECT_EQ(row_of(*scene.bitmaps[1], 1), (std::vector<float>{0, 0, 1, 0}));
  const auto& sides = std::get<BitmapTexture>(scene.textures.at(0).source);
  EXPECT_EQ(sides.wrap_u, TextureWrap::clamp);
  EXPECT_EQ(sides.wrap_v, TextureWrap::mirror);
  // The picture's corners lie one texel within the frame's.
  const glm::dvec3 from = scene.textures[1].uv_transform * glm::dvec3(0, 0, 1);
  const glm::dvec3 to = scene.textures[1].uv_transform * glm::dvec3(1, 1, 1);
  EXPECT_NEAR(glm::distance(from, glm::dvec3(0.25, 1.0 / 3.0, 1.0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::distance(to, glm::dvec3(0.75, 2.0 / 3.0, 1.0)), 0.0, 1e-15);
}

TEST(MitsubaTextures, CheckerboardsHoldTextures) {
  const std::string board = fmt::format(R"(type="checkerboard"><texture name="color0" type="bitmap">{}</texture>
    <texture name="color1" type="scale"><float name="scale" value="0.25"/><texture type="checkerboard"/></texture>)",
                                        kPicture);
  const Read result = read(around(fmt::format(R"(<shape type="disk"><bsdf type="diffuse">
    <texture name="reflectance" {0}</texture></bsdf></shape><shape type="disk"><bsdf type="mask">
    <texture name="opacity" {0}</texture><bsdf type="null"/></bsdf></shape>)",
                                              board)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  const auto& color = std::get<CheckerboardTexture>(
      scene.textures.at(std::get<DiffuseBsdf>(scene.bsdf_of(scene.instances[0])).albedo.texture.value()).source);
  ASSERT_TRUE(color.texture0 && color.texture1);
  EXPECT_TRUE(std::holds_alternative<BitmapTexture>(scene.textures.at(*color.texture0).source));
  EXPECT_EQ(color.color0, glm::dvec3(1.0));
  EXPECT_EQ(color.color1, glm::dvec3(0.25));
  // As a number it has them the other way round.
  const Material& mask = scene.materials.at(scene.instances[1].material);
  const auto& number = std::get<CheckerboardTexture>(
      scene.textures.at(std::get<MaskAdapter>(*mask.adapter).opacity.texture.value()).source);
  EXPECT_EQ(number.color0, glm::dvec3(0.25));
  EXPECT_TRUE(std::holds_alternative<BitmapTexture>(scene.textures.at(number.texture1.value()).source));
}

TEST(MitsubaTextures, CheckerboardsHoldNeitherThemselvesNorColoursOfMeshes) {
  const Read endless = read(around(R"(<texture id="t" type="checkerboard"><ref name="color0" id="t"/></texture>
    <shape type="disk"><bsdf type="diffuse"><ref name="reflectance" id="t"/></bsdf></shape>)"));
  EXPECT_NE(endless.first_error().find("deep within each other"), std::string::npos) << endless.messages();
  const Read colors = read(around(R"(<shape type="disk"><bsdf type="diffuse"><texture name="reflectance"
    type="checkerboard"><texture name="color1" type="mesh_attribute"><string name="name" value="vertex_color"/></texture>
    </texture></bsdf></shape>)"));
  EXPECT_NE(colors.first_error().find("colours of a mesh in a checkerboard"), std::string::npos) << colors.messages();
}

TEST(MitsubaBsdfs, MapsMayLeaveTurnedNormalsAsTheyAre) {
  const Read result = read(around(fmt::format(R"(<shape type="disk"><bsdf type="bumpmap"><texture type="bitmap">{0}
    </texture><boolean name="flip_invalid_normals" value="false"/><bsdf type="diffuse"/></bsdf></shape>
    <shape type="disk"><bsdf type="normalmap"><texture name="normalmap" type="bitmap">{0}</texture>
    <boolean name="use_shadowing_function" value="false"/><bsdf type="diffuse"/></bsdf></shape>)",
                                              kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const auto adapter_of = [&](std::size_t i) {
    return result.scene->materials.at(result.scene->instances.at(i).material).adapter.value();
  };
  EXPECT_EQ(std::get<BumpMapAdapter>(adapter_of(0)).turned, (TurnedNormals{.mirrored = false, .shadowed = true}));
  EXPECT_EQ(std::get<NormalMapAdapter>(adapter_of(1)).turned, (TurnedNormals{.mirrored = true, .shadowed = false}));
}

TEST(MitsubaTextures, MeshesBringTheirCoordinates) {
  const Read result =
      read(around(fmt::format(R"(<bsdf id="b" type="diffuse"><texture name="reflectance" type="bitmap">{}
    </texture></bsdf><shape type="obj"><string name="filename" value="m.obj"/><ref id="b"/></shape>
    <shape type="obj"><string name="filename" value="m.obj"/></shape><shape type="rectangle"><ref id="b"/></shape>)",
                              kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Scene& scene = *result.scene;
  // The file has none: each triangle shows the corner of the picture that Mitsuba calls (0,0), (1,0), (0,1).
  const auto& mesh = std::get<TriangleMesh>(scene.shape_of(scene.instances.at(0)));
  ASSERT_EQ(mesh.uv_sets.size(), 1u);
  EXPECT_EQ(mesh.uv_sets[0], (std::vector<glm::vec2>{{0, 1}, {1, 1}, {0, 0}}));
  EXPECT_TRUE(std::get<TriangleMesh>(scene.shape_of(scene.instances.at(1))).uv_sets.empty());
  const auto& rectangle = std::get<TriangleMesh>(scene.shape_of(scene.instances.at(2)));
  EXPECT_EQ(rectangle.uv_sets.at(0).at(0), glm::vec2(0, 1));  // Mitsuba's (0,0) is at (-1,-1)
}

TEST(MitsubaBsdfs, HaveMitsubasDefaults) {
  const auto glass = std::get<RoughDielectricBsdf>(bsdf_of("<bsdf type=\"roughdielectric\"/>"));
  EXPECT_EQ(glass.int_ior, 1.5046);
  EXPECT_EQ(glass.ext_ior, 1.000277);
  const auto plastic = std::get<RoughPlasticBsdf>(bsdf_of(R"(<bsdf type="roughplastic">
    <float name="alpha" value="0.3"/><string name="int_ior" value="water"/><boolean name="nonlinear" value="true"/></bsdf>)"));
  EXPECT_EQ(plastic.int_ior, 1.333);
  EXPECT_TRUE(plastic.nonlinear);
  EXPECT_EQ(plastic.distribution, Roughness::Distribution::beckmann);
  const auto smooth = std::get<PlasticBsdf>(bsdf_of("<bsdf type=\"plastic\"/>"));
  EXPECT_EQ(smooth.int_ior, 1.49);
  EXPECT_FALSE(smooth.nonlinear);
  const auto pane = std::get<ThinDielectricBsdf>(bsdf_of("<bsdf type=\"thindielectric\"/>"));
  EXPECT_EQ(pane.int_ior, 1.5046);
}

TEST(MitsubaBsdfs, TakeTexturesAndTintsWhereverMitsubaDoes) {
  const auto texture = [](const char* name, const char* within) {
    return fmt::format(R"(<texture{} type="bitmap"><string name="filename" value="p.png"/>{}</texture>)", name, within);
  };
  const auto coat =
      std::get<RoughPlasticBsdf>(bsdf_of("<bsdf type=\"roughplastic\">" + texture(" name=\"alpha\"", "") + "</bsdf>"));
  EXPECT_TRUE(coat.alpha.texture.has_value());
  EXPECT_EQ(coat.alpha.channel, TextureChannel::luminance);
  const auto metal = std::get<RoughConductorBsdf>(
      bsdf_of("<bsdf type=\"roughconductor\">" + texture(" name=\"alpha\"", "<string name=\"channel\" value=\"g\"/>") +
              "</bsdf>"));
  EXPECT_EQ(metal.roughness.alpha_u.channel, TextureChannel::green);
  const Read color =
      read(around("<shape type=\"sphere\"><bsdf type=\"diffuse\">" +
                  texture(" name=\"reflectance\"", "<string name=\"channel\" value=\"g\"/>") + "</bsdf></shape>"));
  EXPECT_NE(color.first_error().find("one channel of a bitmap as a colour"), std::string::npos) << color.messages();
  const auto glass = std::get<DielectricBsdf>(
      bsdf_of("<bsdf type=\"dielectric\"><rgb name=\"specular_transmittance\" value=\"0.2 0.5 0.9\"/></bsdf>"));
  EXPECT_EQ(glass.specular_transmittance.value, glm::dvec3(0.2, 0.5, 0.9));
  EXPECT_EQ(glass.specular_reflectance.value, glm::dvec3(1.0));
  // 0.6 gives the texture of a normal map no name.
  const Read map = read(around("<shape type=\"sphere\"><bsdf type=\"normalmap\">" + texture("", "") +
                               "<bsdf type=\"twosided\"><bsdf type=\"plastic\"/></bsdf></bsdf></shape>"));
  ASSERT_TRUE(map.scene.has_value()) << map.messages();
  EXPECT_TRUE(std::ranges::any_of(map.scene->materials, [](const Material& m) {
    return m.adapter && std::holds_alternative<NormalMapAdapter>(*m.adapter);
  }));
}

TEST(MitsubaEmitters, EnvironmentMapsMayHoldTheirPicture) {
  const auto envmap = [](const std::string& content) {
    return read(around("<shape type=\"sphere\"/><emitter type=\"envmap\">" + content + "</emitter>"));
  };
  const std::string picture = R"(<string name="filename" value="p.png"/>)";
  const Read within =
      envmap("<texture type=\"bitmap\">" + picture + "<boolean name=\"raw\" value=\"true\"/></texture>");
  ASSERT_TRUE(within.scene.has_value()) << within.messages();
  EXPECT_EQ(within.scene->sky.picture->bitmap->color_space, ColorSpace::linear);
  EXPECT_NE(envmap("").first_error().find("an envmap needs its picture"), std::string::npos);
  EXPECT_NE(envmap(picture + "<texture type=\"bitmap\">" + picture + "</texture>").first_error().find("keep one"),
            std::string::npos);
  EXPECT_NE(envmap("<texture type=\"checkerboard\"/>").first_error().find("texture checkerboard of an envmap"),
            std::string::npos);
}

TEST(MitsubaShapes, CylindersMayBeStretchedAlongTheirAxis) {
  const Read result =
      read(around(R"(<shape type="cylinder"><point name="p1" x="0" y="2" z="0"/><transform name="to_world">
    <scale x="0.5" y="3" z="0.5"/><rotate x="1" angle="90"/><translate x="1"/></transform></shape>)"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Instance& instance = result.scene->instances.at(0);
  const auto& cylinder = std::get<Cylinder>(result.scene->shape_of(instance));
  EXPECT_NEAR(cylinder.radius, 0.5, 1e-12);
  EXPECT_NEAR(cylinder.p1.z, 6.0, 1e-12);
  const glm::dvec4 top = instance.world_from_object * glm::dvec4(0, 0, 6, 1);
  EXPECT_NEAR(glm::distance(top, glm::dvec4(1, 0, 6, 1)), 0.0, 1e-12);
  const Read skewed =
      read(around("<shape type=\"cylinder\"><transform name=\"to_world\"><scale x=\"2\"/></transform></shape>"));
  EXPECT_NE(skewed.first_error().find("leaves it no cylinder"), std::string::npos) << skewed.messages();
}

TEST(MitsubaShapes, MirroredMeshesWithoutNormalsOfTheirOwnTurnInsideOut) {
  const Read result =
      read(around(R"(<shape type="obj"><string name="filename" value="m.obj"/><transform name="to_world">
    <scale x="-1"/></transform></shape><shape type="disk"><transform name="to_world"><scale x="-1"/></transform></shape>)"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  EXPECT_TRUE(result.scene->instances.at(0).flip_normals);
  EXPECT_FALSE(result.scene->instances.at(1).flip_normals);
}

TEST(MitsubaSensor, LensesCropsAndMeters) {
  const Camera lens = camera_of(R"(<sensor type="thinlens"><float name="aperture_radius" value="0.25"/>
    <float name="focus_distance" value="7"/></sensor>)");
  EXPECT_EQ(lens.type, Camera::Type::thin_lens);
  EXPECT_EQ(lens.aperture.radius, 0.25);
  EXPECT_EQ(lens.aperture.focus_distance, 7.0);
  const Camera crop = camera_of(R"(<sensor type="orthographic"><film type="hdrfilm">
    <integer name="width" value="100"/><integer name="height" value="50"/><integer name="crop_offset_x" value="20"/>
    <integer name="crop_width" value="30"/><integer name="crop_height" value="10"/></film></sensor>)");
  EXPECT_EQ(crop.type, Camera::Type::orthographic);
  EXPECT_EQ(crop.width, 30u);
  EXPECT_EQ(crop.height, 10u);
  EXPECT_EQ(crop.window.origin, glm::dvec2(0.2, 0.0));
  EXPECT_EQ(crop.window.size, glm::dvec2(0.3, 0.2));
  const Camera meter = camera_of(R"(<sensor type="radiancemeter"><point name="origin" value="1 2 3"/>
    <vector name="direction" value="0 2 0"/></sensor>)");
  EXPECT_EQ(meter.type, Camera::Type::radiance_meter);
  EXPECT_EQ(meter.world_from_camera[2], glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(meter.world_from_camera[3], glm::dvec4(1, 2, 3, 1));
}

/// Rays are those of Mitsuba 3.9.1: they begin two radii of the scene's sphere before what they aim at.
TEST(MitsubaSensor, DistantOnesSeeInOneDirection) {
  const auto sensor = [](const std::string& content) {
    return with_sensor("<sensor type=\"distant\"><vector name=\"direction\" value=\"0 3 -3\"/>" + content +
                       "<film type=\"hdrfilm\"><integer name=\"width\" value=\"1\"/><integer name=\"height\" "
                       "value=\"1\"/></film></sensor>");
  };
  const auto camera = [&](const std::string& content) {
    const Read result = read(sensor(content));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    return result.scene ? result.scene->camera : Camera{};
  };
  const double radius = std::sqrt(3.0), h = std::sqrt(0.5);
  const auto at = [](const Camera& c, const glm::dvec4& p) { return glm::dvec3(c.world_from_camera * p); };
  const auto expect_near = [](const glm::dvec3& a, const glm::dvec3& b) { EXPECT_LT(glm::distance(a, b), 1e-12); };
  const Camera point = camera("<point name=\"target\" value=\"1 2 3\"/>");
  EXPECT_EQ(point.type, Camera::Type::radiance_meter);
  expect_near(at(point, {0, 0, 0, 1}), glm::dvec3(1, 2, 3) - 2.0 * radius * glm::dvec3(0, h, -h));
  expect_near(at(point, {0, 0, 1, 0}), {0, h, -h});
  const Camera rectangle = camera(
      "<shape name=\"target\" type=\"rectangle\"><transform name=\"to_world\"><scale x=\"2\" y=\"3\"/></transform>"
      "</shape>");
  EXPECT_EQ(rectangle.type, Camera::Type::orthographic);
  EXPECT_EQ(rectangle.filter.type, ReconstructionFilter::Type::box);
  expect_near(at(rectangle, {1, -1, 0, 1}), glm::dvec3(2, -3, 0) - 2.0 * radius * glm::dvec3(0, h, -h));
  expect_near(glm::normalize(at(rectangle, {0, 0, 1, 0})), {0, h, -h});
  const Camera disk = camera("<shape type=\"disk\"/>");
  EXPECT_EQ(disk.type, Camera::Type::thin_lens);
  EXPECT_EQ(disk.aperture.radius, 1.0);
  expect_near(at(disk, {1, 0, 0, 1}), glm::dvec3(1, 0, 0) - 2.0 * radius * glm::dvec3(0, h, -h));
  const Camera all = camera("");
  EXPECT_EQ(all.type, Camera::Type::thin_lens);
  EXPECT_NEAR(glm::length(at(all, {1, 0, 0, 0})), radius, 1e-12);
  EXPECT_NEAR(glm::length(at(all, {0, 1, 0, 0})), radius, 1e-12);
  EXPECT_NEAR(glm::dot(at(all, {1, 0, 0, 0}), glm::dvec3(0, h, -h)), 0.0, 1e-12);
  EXPECT_NE(read(sensor("<shape type=\"cube\"/>")).first_error().find("distant that aims at a cube"),
            std::string::npos);
  EXPECT_NE(read(with_sensor("<sensor type=\"distant\"/>")).first_error().find("768 by 576"), std::string::npos);
  EXPECT_NE(read(sensor("<shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"-45\"/>"
                        "</transform></shape>"))
                .first_error()
                .find("looks along the surface"),
            std::string::npos);
}

TEST(MitsubaSensor, AMeterStandsInItsRectangle) {
  const std::string meter =
      "<sensor type=\"irradiancemeter\"><film type=\"hdrfilm\"><integer name=\"width\" value=\"1\"/><integer "
      "name=\"height\" value=\"2\"/></film></sensor>";
  const auto scene_of = [&](const std::string& type, const std::string& properties) {
    return read("<scene version=\"3.0.0\"><shape type=\"sphere\"/><shape type=\"" + type + "\">" + properties +
                "<transform name=\"to_world\"><translate z=\"3\"/></transform>" + meter + "</shape></scene>");
  };
  const Read result = scene_of("rectangle", "");
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const Camera& camera = result.scene->camera;
  EXPECT_EQ(camera.type, Camera::Type::irradiance_meter);
  EXPECT_EQ(camera.width, 1u);
  EXPECT_EQ(camera.height, 2u);
  EXPECT_EQ(camera.world_from_camera[3], glm::dvec4(0, 0, 3, 1));
  EXPECT_EQ(camera.world_from_camera[2], glm::dvec4(0, 0, 1, 0));
  EXPECT_EQ(result.scene->instances.size(), 2u);  // the rectangle is seen, too
  const Read flipped = scene_of("rectangle", "<boolean name=\"flip_normals\" value=\"true\"/>");
  ASSERT_TRUE(flipped.scene.has_value()) << flipped.messages();
  EXPECT_EQ(flipped.scene->camera.world_from_camera[2], glm::dvec4(0, 0, -1, 0));
  EXPECT_GT(glm::determinant(glm::dmat3(flipped.scene->camera.world_from_camera)), 0.0);
  EXPECT_NE(scene_of("cube", "").first_error().find("irradiancemeter on a cube"), std::string::npos);
  EXPECT_NE(read(with_sensor(meter)).first_error().find("belongs in the <shape>"), std::string::npos);
  EXPECT_NE(read("<scene version=\"3.0.0\"/>").first_error().find("<scene> needs a <sensor>"), std::string::npos);
}

TEST(MitsubaEmitters, EnvironmentMaps) {
  const Read result =
      read(around(fmt::format(R"(<shape type="sphere"/><emitter type="envmap">{}<float name="scale" value="2"/>
    <transform name="to_world"><rotate x="1" angle="90"/></transform></emitter>)",
                              kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  ASSERT_TRUE(result.scene->sky.picture.has_value());
  EXPECT_EQ(result.scene->sky.picture->scale, 2.0);
  EXPECT_EQ(result.scene->sky.picture->rows, SkyPicture::Rows::circles);
  EXPECT_NEAR(result.scene->sky.world_from_sky[1].z, 1.0, 1e-12);
}

TEST(MitsubaEmitters, LightsWithoutExtent) {
  const Read result = read(around(fmt::format(R"(<emitter type="point"><point name="position" x="1" y="2" z="3"/>
    <rgb name="intensity" value="2 3 4"/></emitter>
    <emitter type="spot"><rgb name="intensity" value="3"/><float name="cutoff_angle" value="40"/>
    <transform name="to_world"><lookat origin="0 5 0" target="0 0 0" up="0 0 1"/></transform>
    <texture name="texture" type="bitmap">{0}</texture></emitter>
    <emitter type="directional"><vector name="direction" x="0" y="-3" z="0"/><rgb name="irradiance" value="2"/></emitter>
    <emitter type="projector"><texture name="irradiance" type="bitmap">{0}</texture><float name="scale" value="5"/>
    <float name="fov" value="90"/></emitter>)",
                                              kPicture)));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const std::vector<DeltaLight>& lights = result.scene->delta_lights;
  ASSERT_EQ(lights.size(), 4u);
  EXPECT_EQ(lights[0].origin(), glm::dvec3(1, 2, 3));
  EXPECT_EQ(lights[0].intensity.value, glm::dvec3(2, 3, 4));
  EXPECT_EQ(lights[1].type, DeltaLight::Type::spot);
  EXPECT_EQ(lights[1].beam_width, 30.0);
  EXPECT_EQ(lights[1].intensity.value, glm::dvec3(3.0));
  EXPECT_TRUE(lights[1].intensity.texture.has_value());
  EXPECT_LT(glm::distance(lights[1].axis(2), glm::dvec3(0, -1, 0)), 1e-12);
  EXPECT_LT(glm::distance(lights[2].axis(2), glm::dvec3(0, -1, 0)), 1e-12);
  EXPECT_NEAR(lights[3].intensity.value.x, 5.0 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(lights[3].slope.x, 1.0, 1e-12);
}

TEST(MitsubaMissing, AllIsListedAtOnce) {
  const std::string text = around(R"(<integrator type="stokes"/><emitter type="collimated"/>
    <shape type="sphere"><bsdf type="hair"/></shape>
    <shape type="sphere"><bsdf type="hair"/></shape>
    <shape type="sdfgrid"/><shape type="sphere"><medium type="homogeneous" name="interior"/></shape>)");
  const Read refused = read(text);
  EXPECT_FALSE(refused.scene.has_value());
  EXPECT_EQ(refused.diagnostics.error_count(), 1u) << refused.messages();
  const std::string error = refused.first_error();
  for (const char* part :
       {"bsdf hair (s.xml:3:26, s.xml:4:26)", "emitter collimated (s.xml:2:28)", "integrator stokes (s.xml:2:1)",
        "medium homogeneous (s.xml:5:", "shape sdfgrid (s.xml:5:5)"})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
  const Read approximated = read(text, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(approximated.scene.has_value()) << approximated.messages();
  EXPECT_EQ(approximated.scene->instances.size(), 3u);
  EXPECT_NE(approximated.messages().find("bsdf hair is approximated: diffuse, grey"), std::string::npos);
}

// What stands in a shape that is left out, by itself or by reference, and what stands in that.
TEST(MitsubaMissing, WhatMissingThingsHoldIsListedToo) {
  const std::string text = around(R"(<bsdf type="hair" id="h"/>
    <shape type="sdfgrid"><bsdf type="twosided"><ref id="h"/></bsdf></shape>
    <shape type="linearcurve"><ref id="h"/><medium type="homogeneous" name="interior"/></shape>)");
  const std::string error = read(text).first_error();
  for (const char* part : {"bsdf hair (s.xml:2:1);", "shape sdfgrid (s.xml:3:5)", "shape linearcurve (s.xml:4:5)",
                           "medium homogeneous (s.xml:4:"})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
}

TEST(MitsubaMissing, CirclesOfMissingThingsEnd) {
  const std::string text = around(R"(<bsdf type="hair" id="a"><ref id="b"/></bsdf>
    <bsdf type="difftrans" id="b"><ref id="a"/></bsdf><shape type="sphere"><ref id="a"/></shape>)");
  const std::string error = read(text).first_error();
  for (const char* part : {"bsdf hair (s.xml:2:1", "bsdf difftrans (s.xml:3:5"})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
}

TEST(MitsubaMissing, WhatMovesStandsStillWhereItBegins) {
  const std::string text = around(R"(<shape type="sphere"><animation name="to_world">
    <transform time="1"><translate x="5"/></transform><transform time="0"><translate x="3"/></transform>
    </animation></shape>)");
  EXPECT_NE(read(text).first_error().find("animation (s.xml:2:22)"), std::string::npos) << read(text).messages();
  const Read approximated = read(text, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(approximated.scene.has_value()) << approximated.messages();
  EXPECT_EQ(approximated.scene->instances.at(0).world_from_object[3].x, 3.0);
}

TEST(MitsubaMissing, MaterialsLikeOthersAreReadAsThose) {
  const std::string text = around(R"(<shape type="sphere"><bsdf type="pplastic"><float name="alpha" value="0.3"/></bsdf>
    </shape><shape type="sphere"><bsdf type="roughdiffuse"><rgb name="reflectance" value="0.1"/></bsdf></shape>)");
  const std::string error = read(text).first_error();
  for (const char* part : {"bsdf pplastic (s.xml:2:22)", "bsdf roughdiffuse (s.xml:3:34)"})
    EXPECT_NE(error.find(part), std::string::npos) << part << " in " << error;
  const Read approximated = read(text, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(approximated.scene.has_value()) << approximated.messages();
  EXPECT_EQ(std::get<RoughPlasticBsdf>(approximated.scene->materials.at(0).bsdf).alpha.value, 0.3);
  EXPECT_EQ(std::get<DiffuseBsdf>(approximated.scene->materials.at(1).bsdf).albedo.value, glm::dvec3(0.1));
}

TEST(MitsubaMissing, RaysThroughTheMiddleOfPixels) {
  const auto sensor = [](const char* jitter) {
    return with_sensor(fmt::format(R"(<sensor type="perspective"><float name="fov" value="40"/>
    <boolean name="jitter" value="{}"/><float name="cone_scale" value="2"/></sensor>)",
                                   jitter));
  };
  EXPECT_TRUE(read(sensor("true")).scene.has_value());
  EXPECT_NE(read(sensor("false")).first_error().find("a sensor without jitter (s.xml:2:5)"), std::string::npos);
}

TEST(MitsubaMissing, UnknownPropertiesAreWarnings) {
  const std::string text = around("<shape type=\"sphere\"><float name=\"raduis\" value=\"2\"/></shape>");
  const Read lenient = read(text);
  EXPECT_TRUE(lenient.scene.has_value());
  EXPECT_NE(lenient.messages().find("did you mean \"radius\""), std::string::npos) << lenient.messages();
  EXPECT_FALSE(read(text, {.overrides = {}, .strict = true}).scene.has_value());
}

// Mitsuba only warns of a sphere that is scaled unevenly.
TEST(MitsubaMissing, WhatBreaksAnInvariantIsAnError) {
  const Read result =
      read(around("<shape type=\"sphere\"><transform name=\"to_world\"><scale value=\"1 2 1\"/></transform></shape>"));
  EXPECT_FALSE(result.scene.has_value());
  EXPECT_EQ(result.first_error().find("s.xml:2:1:"), 0u) << result.messages();
}

TEST(MitsubaAdapters, BecomeRows) {
  const Read result = read(around(R"(<shape type="sphere"><bsdf type="mask"><float name="opacity" value="0.25"/>
      <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></bsdf></shape>
      <shape type="sphere"><bsdf type="blendbsdf"><float name="weight" value="0.75"/><bsdf type="conductor"/>
      <bsdf type="null"/></bsdf></shape>)"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const std::vector<Material>& rows = result.scene->materials;
  ASSERT_EQ(rows.size(), 6u);
  const auto& sides = std::get<TwoSidedAdapter>(rows[1].adapter.value());
  EXPECT_EQ(sides.front, 0u);
  EXPECT_EQ(sides.back, 0u);
  const auto& mask = std::get<MaskAdapter>(rows[2].adapter.value());
  EXPECT_EQ(mask.opacity.value, 0.25);
  EXPECT_EQ(mask.inner, 1u);
  const auto& blend = std::get<BlendAdapter>(rows[5].adapter.value());
  EXPECT_EQ(blend.weight.value, 0.75);
  EXPECT_EQ(blend.first, 3u);
  EXPECT_EQ(blend.second, 4u);
}

TEST(MitsubaAdapters, BumpsHaveATextureOfAnyName) {
  for (const char* name : {"", "name=\"displacement\" ", "name=\"floor_tiles\" "}) {
    const Read result =
        read(around(fmt::format("<shape type=\"rectangle\"><bsdf type=\"bumpmap\"><float name=\"scale\" value=\"2\"/>"
                                "<texture {}type=\"bitmap\"><string name=\"filename\" value=\"p.png\"/></texture>"
                                "<bsdf type=\"diffuse\"/></bsdf></shape>",
                                name)));
    ASSERT_TRUE(result.scene.has_value()) << result.messages();
    const auto& bumps = std::get<BumpMapAdapter>(result.scene->materials.at(1).adapter.value());
    EXPECT_EQ(bumps.height.value, 2.0);
    EXPECT_TRUE(bumps.height.texture.has_value());
  }
  const Read lacking =
      read(around("<shape type=\"rectangle\"><bsdf type=\"bumpmap\"><bsdf type=\"diffuse\"/></bsdf>"
                  "</shape><shape type=\"rectangle\"><bsdf type=\"normalmap\"/></shape>"));
  EXPECT_NE(lacking.messages().find("<bsdf type=\"bumpmap\"> needs a <texture>"), std::string::npos);
  EXPECT_NE(lacking.messages().find("<bsdf type=\"normalmap\"> needs a <bsdf>"), std::string::npos);
}

TEST(MitsubaAdapters, AMaterialCannotStandInItself) {
  const Read result = read(around(R"(<bsdf type="twosided" id="a"><ref id="a"/></bsdf>
      <shape type="sphere"><ref id="a"/></shape>)"));
  EXPECT_FALSE(result.scene.has_value());
  EXPECT_NE(result.first_error().find("contains itself"), std::string::npos) << result.messages();
}

TEST(MitsubaTransforms, LookWithoutUp) {
  const auto up = [](const char* version) {
    const Read result =
        read(fmt::format(R"(<scene version="{}"><sensor type="perspective"><float name="fov" value="40"/>
      <transform name="toWorld"><lookat origin="1 2 3" target="4 2 3"/></transform></sensor>
      <shape type="sphere"/></scene>)",
                         version));
    EXPECT_TRUE(result.scene.has_value()) << result.messages();
    return result.scene ? glm::dvec3(result.scene->camera.world_from_camera[1]) : glm::dvec3(0.0);
  };
  EXPECT_EQ(up("3.0.0"), glm::dvec3(0, 0, -1));
  EXPECT_EQ(up("0.6.0"), glm::dvec3(0, -1, 0));
}

TEST(MitsubaMissing, TypesOfRenderersOfSomebodysOwn) {
  const std::string text = around(R"(<integrator type="guided_path"><integer name="sppPerPass" value="1"/></integrator>
    <shape type="sphere"><bsdf type="disneybsdf"/></shape>)");
  const Read refused = read(text);
  EXPECT_NE(refused.first_error().find("bsdf disneybsdf (s.xml:3:"), std::string::npos) << refused.messages();
  EXPECT_NE(refused.first_error().find("integrator guided_path (s.xml:2:1)"), std::string::npos);
  const Read approximated = read(text, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(approximated.scene.has_value()) << approximated.messages();
  EXPECT_EQ(approximated.scene->integrator.type, Integrator::Type::path);
  // A slip of the pen stays one.
  EXPECT_NE(read(around("<shape type=\"spere\"/>")).first_error().find("did you mean \"sphere\"?"), std::string::npos);
  EXPECT_TRUE(read(around("<shape type=\"Rectangle\"/>")).scene.has_value());
  EXPECT_NE(
      read(around("<shape type=\"sphere\"><animation name=\"to_world\"/></shape>")).first_error().find("animation"),
      std::string::npos);
}

TEST(MitsubaMissing, LobesOfPhongAndWard) {
  const std::string text = around(R"(<shape type="sphere"><bsdf type="phong"><float name="exponent" value="6"/>
      <rgb name="diffuseReflectance" value="0.3"/><rgb name="specularReflectance" value="0.1"/></bsdf></shape>
    <shape type="sphere"><bsdf type="ward"><float name="alphaU" value="0.2"/><float name="alphaV" value="0.4"/>
      <string name="variant" value="ward-duer"/></bsdf></shape>)");
  EXPECT_NE(read(text).first_error().find("bsdf phong (s.xml:2:22); bsdf ward (s.xml:4:26)"), std::string::npos)
      << read(text).messages();
  const Read result = read(text, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const std::vector<Material>& rows = result.scene->materials;
  ASSERT_EQ(rows.size(), 6u);
  const auto& blend = std::get<BlendAdapter>(rows[2].adapter.value());
  EXPECT_NEAR(blend.weight.value, 0.25, 1e-12);
  const auto& base = std::get<DiffuseBsdf>(rows[blend.first].bsdf);
  const auto& lobe = std::get<RoughConductorBsdf>(rows[blend.second].bsdf);
  // What both reflect in the mean is what the file says.
  EXPECT_NEAR(0.75 * base.albedo.value.x, 0.3, 1e-12);
  EXPECT_NEAR(0.25 * lobe.specular_reflectance.value.x, 0.1, 1e-12);
  EXPECT_EQ(lobe.roughness.alpha_u.value, 0.5);  // √(2/(6 + 2))
  const auto& ward = std::get<RoughConductorBsdf>(rows[4].bsdf);
  EXPECT_EQ(ward.roughness.alpha_u.value, 0.2);
  EXPECT_EQ(ward.roughness.alpha_v.value, 0.4);
}

TEST(MitsubaMissing, CoatsAreLeftOut) {
  const std::string text = around(R"(<shape type="sphere"><bsdf type="roughcoating"><float name="alpha" value="0.1"/>
    <bsdf type="conductor"><string name="material" value="Au"/></bsdf></bsdf></shape>)");
  EXPECT_NE(read(text).first_error().find("bsdf roughcoating (s.xml:2:22)"), std::string::npos);
  const Read result = read(text, {.overrides = {}, .approximate = true});
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  const auto& all =
      std::get<MaskAdapter>(result.scene->materials.at(result.scene->instances[0].material).adapter.value());
  EXPECT_EQ(all.opacity.value, 1.0);
  EXPECT_TRUE(std::holds_alternative<ConductorBsdf>(result.scene->materials[all.inner].bsdf));
}

TEST(MitsubaAdapters, MixturesAreBlends) {
  const auto mixture = [](const std::string& weights) {
    return read(
        around("<shape type=\"sphere\"><bsdf type=\"mixturebsdf\"><string name=\"weights\" value=\"" + weights +
               "\"/><bsdf type=\"dielectric\"/><bsdf type=\"conductor\"/><bsdf type=\"null\"/></bsdf></shape>"));
  };
  /// The share of each row that the material comes to in the end.
  const auto shares = [](const Scene& scene) {
    std::map<std::uint32_t, double> found;
    const auto follow = [&](const auto& self, std::uint32_t row, double share) -> void {
      const Material& material = scene.materials.at(row);
      if (!material.adapter) return void(found[row] += share);
      const auto& blend = std::get<BlendAdapter>(*material.adapter);
      self(self, blend.first, share * (1.0 - blend.weight.value));
      self(self, blend.second, share * blend.weight.value);
    };
    follow(follow, scene.instances.at(0).material, 1.0);
    return found;
  };
  const Read whole = mixture("0.5, 0.3, 0.2");
  ASSERT_TRUE(whole.scene.has_value()) << whole.messages();
  auto share = shares(*whole.scene);
  EXPECT_NEAR(share[0], 0.5, 1e-12);
  EXPECT_NEAR(share[1], 0.3, 1e-12);
  EXPECT_NEAR(share[2], 0.2, 1e-12);
  const Read dark = mixture("0.25 0.25 0.25");
  ASSERT_TRUE(dark.scene.has_value()) << dark.messages();
  share = shares(*dark.scene);
  EXPECT_NEAR(share[2], 0.25, 1e-12);
  EXPECT_NEAR(share[3], 0.25, 1e-12);
  EXPECT_EQ(std::get<DiffuseBsdf>(dark.scene->materials.at(3).bsdf).albedo.value, glm::dvec3(0.0));
  const Read much = mixture("2, 1, 1");
  ASSERT_TRUE(much.scene.has_value()) << much.messages();
  EXPECT_NEAR(shares(*much.scene)[0], 0.5, 1e-12);
  EXPECT_NE(much.messages().find("the weights add up to 4"), std::string::npos);
  EXPECT_NE(mixture("1, 0").first_error().find("2 weights for 3 materials"), std::string::npos);
  EXPECT_NE(mixture("1, 0, -1").first_error().find("-1 is out of range"), std::string::npos);
  EXPECT_TRUE(mixture("0, 0, 1").scene.has_value());
}

TEST(MitsubaMaterials, PrincipledWithoutHighlights) {
  const Bsdf bsdf = bsdf_of("<bsdf type=\"principled\"><float name=\"specular\" value=\"0\"/></bsdf>");
  EXPECT_NEAR(std::get<PrincipledBsdf>(bsdf).eta.value, 1.0011, 1e-9);
}

TEST(MitsubaIntegrators, AovsAlone) {
  const Read result =
      read(around("<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth\"/></integrator>"
                  "<shape type=\"sphere\"/>"));
  ASSERT_TRUE(result.scene.has_value()) << result.messages();
  EXPECT_EQ(result.scene->aovs, std::vector{Aov::depth});
}

}  // namespace
}  // namespace etendue::testing
