// What the scenes of courses have beside Nori's own: read where it can mean one thing only, named where it cannot.

#include <gmock/gmock.h>

#include "formats/nori/plugins.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A picture of 2 x 1 pixels.
constexpr std::string_view kPicture =
    "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x80\x80\x80\x82";

/// Of a scene in a folder with a.hdr.
Parsed parse_beside_picture(const std::string& content, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  folder.write("a.hdr", kPicture);
  Parsed result;
  result.file =
      parse_scene_file(scene_around(content), folder.path("s.xml"), options, load_triangle, result.diagnostics);
  return result;
}

Scene read_beside_picture(const std::string& content) {
  const Parsed parsed = parse_beside_picture(content);
  EXPECT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
  return parsed.file ? parsed.scene() : Scene{};
}

std::string sphere(const std::string& content) {
  return "<mesh type=\"sphere\">" + content + "</mesh>";
}

TEST(Courses, NumbersUnderOtherTags) {
  const Scene scene = read_beside_picture(sphere(
      R"(<vector name="center" value="1 2 3"/><integer name="radius" value="2"/>
         <bsdf type="conductor"><float name="eta" value="0.25"/><integer name="k" value="3"/></bsdf>)"));
  const auto& ball = std::get<Sphere>(scene.shapes.at(0));
  EXPECT_EQ(ball.center, glm::dvec3(1, 2, 3));
  EXPECT_EQ(ball.radius, 2.0);
  const auto& metal = std::get<ConductorBsdf>(scene.materials.at(0).bsdf);
  EXPECT_EQ(metal.index.eta.value, glm::dvec3(0.25));
  EXPECT_EQ(metal.index.k.value, glm::dvec3(3.0));
  const Parsed wrong = parse_beside_picture(sphere(R"(<bsdf type="conductor"><float name="eta" value="1 2"/></bsdf>)"));
  EXPECT_THAT(all_messages(wrong.diagnostics), HasSubstr("\"eta\""));
  EXPECT_FALSE(wrong.file);
}

TEST(Courses, NamesAndVersionsThatMeanNothing) {
  const Parsed parsed = parse(
      R"(<scene version="0.5.0"><integrator type="path" name="i"/><camera type="perspective"/>
         <mesh type="sphere" name="ball"><bsdf type="diffuse" name="red"/></mesh></scene>)");
  EXPECT_EQ(all_messages(parsed.diagnostics), "");
  EXPECT_TRUE(parsed.file);
}

TEST(Courses, LuminairesAreEmitters) {
  const Scene scene =
      read_beside_picture(sphere(R"(<luminaire type="area"><color name="radiance" value="1 2 3"/></luminaire>)"));
  EXPECT_EQ(scene.emitters.at(0).radiance.value, glm::dvec3(1, 2, 3));
}

TEST(Courses, TagsThatArePassedOver) {
  const Parsed parsed = parse_beside_picture(
      R"(<acceleration type="bvh"><integer name="leafSize" value="10"/></acceleration><denoiser type="simple"/>)" +
      sphere(""));
  EXPECT_TRUE(parsed.file);
  const std::string messages = all_messages(parsed.diagnostics);
  EXPECT_THAT(messages, HasSubstr("2:1: <acceleration> is ignored"));
  EXPECT_THAT(messages, HasSubstr("<denoiser> is ignored: rendering does not denoise"));
  ASSERT_EQ(parsed.diagnostics.list().size(), 2u);
  EXPECT_EQ(parsed.diagnostics.list()[0].severity, Severity::note);
  EXPECT_EQ(parsed.diagnostics.list()[1].severity, Severity::warning);
}

TEST(Courses, OneNumberIsAGrey) {
  const Scene scene =
      read_beside_picture(sphere(R"(<bsdf type="diffuse"><color name="albedo" value=" 0.25 "/></bsdf>)") +
                          sphere(R"(<emitter type="area"><float name="radiance" value="3"/></emitter>)"));
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.materials.at(0).bsdf).albedo.value, glm::dvec3(0.25));
  EXPECT_EQ(scene.emitters.at(0).radiance.value, glm::dvec3(3.0));
}

/// Each lies on the surface for itself.
TEST(Courses, CheckerboardsHoldTextures) {
  const Scene scene = read_beside_picture(sphere(R"(<bsdf type="diffuse"><texture type="checkerboard" name="albedo">
    <texture type="checkerboard_color" name="color0"/><color name="color1" value="0.5"/></texture></bsdf>)"));
  const auto& board = std::get<CheckerboardTexture>(scene.textures.at(1).source);
  EXPECT_EQ(board.texture0, 0u);
  EXPECT_EQ(board.color0, glm::dvec3(1.0));
  EXPECT_FALSE(board.texture1.has_value());
  EXPECT_EQ(board.color1, glm::dvec3(0.5));
}

/// They need no texture coordinates, which courses' meshes often lack.
TEST(Courses, ConstantTexturesAreColoursAndNumbers) {
  const Scene scene = read_beside_picture(sphere(R"(<bsdf type="diffuse"><texture type="checkerboard" name="albedo">
    <texture type="constant" name="color0"><color name="value" value="0.1 0.2 0.3"/></texture></texture></bsdf>)") +
                                          sphere(R"(<bsdf type="roughconductor"><texture type="constant" name="alpha">
    <color name="value" value="0.25 0.5 1"/><string name="channel" value="green"/></texture></bsdf>)"));
  ASSERT_EQ(scene.textures.size(), 1u);
  const auto& board = std::get<CheckerboardTexture>(scene.textures[0].source);
  EXPECT_FALSE(board.texture0.has_value());
  EXPECT_EQ(board.color0, glm::dvec3(0.1, 0.2, 0.3));
  const auto& metal = std::get<RoughConductorBsdf>(scene.materials.at(1).bsdf);
  EXPECT_EQ(metal.roughness.alpha_u.value, 0.5);
  EXPECT_FALSE(metal.roughness.alpha_u.texture.has_value());
}

TEST(Courses, TexturesWithoutANameAreTheColour) {
  const Scene scene = read_beside_picture(
      sphere(
          R"(<bsdf type="diffuse"><texture type="solid"><color name="albedo" value="0.1 0.2 0.3"/></texture></bsdf>)") +
      sphere(
          R"(<bsdf type="microfacet"><texture type="constant"><color name="value" value="0.4 0.5 0.6"/></texture></bsdf>
        <emitter type="area"><texture type="checkerboard_color"/><float name="scale" value="3"/></emitter>)"));
  const auto color = [&](const ColorParameter& parameter) {
    if (!parameter.texture) return parameter.value;
    return std::get<CheckerboardTexture>(scene.textures.at(*parameter.texture).source).color0;
  };
  EXPECT_EQ(color(std::get<DiffuseBsdf>(scene.materials.at(0).bsdf).albedo), glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(color(std::get<MicrofacetBsdf>(scene.materials.at(1).bsdf).kd), glm::dvec3(0.4, 0.5, 0.6));
  EXPECT_EQ(color(scene.emitters.at(0).radiance), glm::dvec3(0.0));
  EXPECT_EQ(scene.emitters.at(0).radiance.value, glm::dvec3(3.0));
  // A metal has several, none of which is its colour.
  const Parsed metal = parse_beside_picture(sphere(R"(<bsdf type="conductor"><texture type="solid"/></bsdf>)"));
  EXPECT_THAT(all_messages(metal.diagnostics), HasSubstr("needs the name of a property: \"eta\", \"k\""));
}

TEST(Courses, TexturesOfMeshes) {
  const std::string picture = R"(<string name="filename" value="a.hdr"/>)";
  const Scene scene = read_beside_picture(
      R"(<bsdf type="diffuse" id="paint"><color name="albedo" value="0.1 0.2 0.3"/></bsdf>)" +
      sphere(R"(<ref id="paint"/><texture type="bitmap">)" + picture + "</texture>") + sphere(R"(<ref id="paint"/>)") +
      sphere(R"(<ref id="paint"/><texture type="normal_map">)" + picture + "</texture>") +
      sphere(R"(<ref id="paint"/><texture type="bitmap"><string name="id" value="normal"/>)" + picture + "</texture>"));
  const auto row = [&](std::size_t i) -> const Material& { return scene.materials.at(scene.instances.at(i).material); };
  EXPECT_TRUE(std::get<DiffuseBsdf>(row(0).bsdf).albedo.texture.has_value());
  EXPECT_EQ(std::get<DiffuseBsdf>(row(1).bsdf).albedo.value, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_FALSE(std::get<DiffuseBsdf>(row(1).bsdf).albedo.texture.has_value());
  for (const std::size_t i : {2u, 3u}) {
    ASSERT_TRUE(row(i).adapter.has_value());
    const auto& normals = std::get<NormalMapAdapter>(*row(i).adapter);
    EXPECT_EQ(normals.inner, scene.instances.at(1).material);
    const auto& source = std::get<BitmapTexture>(scene.textures.at(normals.normals.texture.value()).source);
    EXPECT_EQ(source.color_space, ColorSpace::linear);
  }
  const Parsed glass =
      parse_beside_picture(sphere(R"(<bsdf type="dielectric"/><texture type="bitmap">)" + picture + "</texture>"));
  EXPECT_THAT(all_messages(glass.diagnostics), HasSubstr("has no colour that this texture could be"));
}

TEST(Courses, PicturesOfASizeInTextureCoordinates) {
  const Scene scene = read_beside_picture(sphere(R"(<bsdf type="diffuse"><texture type="imageTexture" name="albedo">
    <string name="fileName" value="a.hdr"/><vector name="scale" value="0.5 0.25"/><point name="delta" value="0.1 0.2"/>
    <string name="interpolation" value="Closest"/><string name="extension" value="EXTEND"/></texture></bsdf>)"));
  const Texture& texture = scene.textures.at(0);
  const glm::dvec3 at = texture.uv_transform * glm::dvec3(1.0, 1.0, 1.0);
  EXPECT_NEAR(at.x, 1.0 / 0.5 - 0.1, 1e-12);
  EXPECT_NEAR(at.y, 1.0 / 0.25 - 0.2, 1e-12);
  const auto& picture = std::get<BitmapTexture>(texture.source);
  EXPECT_EQ(picture.filter, TextureFilter::nearest);
  EXPECT_EQ(picture.wrap_u, TextureWrap::clamp);
  // As a colour, scale is still a factor.
  const Scene factor = read_beside_picture(sphere(R"(<bsdf type="diffuse"><texture type="bitmap" name="albedo">
    <string name="filename" value="a.hdr"/><color name="scale" value="0.5 0.5 0.5"/></texture></bsdf>)"));
  EXPECT_EQ(std::get<DiffuseBsdf>(factor.materials.at(0).bsdf).albedo.value, glm::dvec3(0.5));
  const Parsed none = parse_beside_picture(sphere(R"(<bsdf type="diffuse"><texture type="bitmap" name="albedo">
    <string name="filename" value="a.hdr"/><vector name="scale" value="0 1"/></texture></bsdf>)"));
  EXPECT_THAT(all_messages(none.diagnostics), HasSubstr("a size of 0 leaves no picture"));
}

TEST(Courses, TheSkyOnASphere) {
  const Parsed parsed = parse_beside_picture(
      R"(<mesh type="sphere"><float name="radius" value="30"/><emitter type="environment">
         <string name="filename" value="a.hdr"/><float name="strength" value="4"/></emitter></mesh>)" +
      sphere(""));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr("is read as light from all around the scene"));
  const Scene& scene = parsed.scene();
  EXPECT_EQ(scene.instances.size(), 1u);
  ASSERT_TRUE(scene.sky.picture);
  EXPECT_EQ(scene.sky.picture->scale, 4.0);
  const std::string sky = R"(<emitter type="env"><string name="exr_path" value="a.hdr"/></emitter>)";
  EXPECT_TRUE(parse_beside_picture(sky).file);
  EXPECT_THAT(all_messages(parse_beside_picture(sky + sphere(sky)).diagnostics), HasSubstr("a second emitter"));
}

TEST(Courses, StrengthsOfLights) {
  const Scene scene = read_beside_picture(
      R"(<emitter type="point"><point name="position" value="1 2 3"/><color name="intensity" value="2 2 2"/>
           <float name="scale" value="3"/></emitter>
         <emitter type="directional"><vector name="direction" value="0 -1 0"/><color name="radiance" value="1 2 3"/>
           <float name="strength" value="5"/></emitter>
         <emitter type="spotLight"><point name="origin" value="0 4 0"/><point name="lookAt" value="0 0 0"/>
           <color name="intensity" value="1 1 1"/><float name="cosTotalWidth" value="30"/>
           <float name="cosFalloffStart" value="20"/></emitter>)" +
      sphere(
          R"(<emitter type="area"><color name="radiance" value="1 1 1"/><float name="strength" value="7"/></emitter>)"));
  EXPECT_EQ(scene.delta_lights.at(0).intensity.value, glm::dvec3(6.0));
  EXPECT_EQ(scene.delta_lights.at(1).intensity.value, glm::dvec3(5, 10, 15));
  const DeltaLight& spot = scene.delta_lights.at(2);
  EXPECT_EQ(spot.origin(), glm::dvec3(0, 4, 0));
  EXPECT_EQ(spot.cutoff, 30.0);
  EXPECT_EQ(spot.beam_width, 20.0);
  EXPECT_EQ(scene.emitters.at(0).radiance.value, glm::dvec3(7.0));
}

TEST(Courses, PropertiesThatAreGivenTwiceAlike) {
  const std::string once = "<float name=\"radius\" value=\"2\"/>";
  const Parsed alike = parse_beside_picture(sphere(once + "<float name=\"radius\" value=\"2.0\"/>"));
  EXPECT_TRUE(alike.file);
  EXPECT_THAT(all_messages(alike.diagnostics), HasSubstr("is given twice with the same value"));
  const Parsed other = parse_beside_picture(sphere(once + "<float name=\"radius\" value=\"3\"/>"));
  EXPECT_FALSE(other.file);
  EXPECT_THAT(all_messages(other.diagnostics), HasSubstr("is given twice; keep one"));
}

TEST(Courses, FocalLengthOfALensWhoseViewIsKnown) {
  const std::string view = R"(<float name="fov" value="40"/><float name="focalLength" value="9.5"/>)";
  const auto camera = [&](const std::string& content) {
    return parse("<scene><integrator type=\"path\"/><camera type=\"perspective\">" + content +
                 "</camera><mesh type=\"sphere\"/></scene>");
  };
  const Parsed lens = camera(view + R"(<float name="radius" value="0.03"/>)");
  ASSERT_TRUE(lens.file) << all_messages(lens.diagnostics);
  EXPECT_EQ(lens.scene().camera.aperture.focus_distance, 9.5);
  EXPECT_EQ(lens.scene().camera.fov, 40.0);
  EXPECT_THAT(all_messages(lens.diagnostics), HasSubstr("is read as \"focusDistance\""));
  EXPECT_THAT(all_messages(camera(view).diagnostics), HasSubstr("both say how wide the view is"));
}

TEST(Courses, PicturesOfTheSkyMayBeTextures) {
  const auto sky = [](const std::string& content) {
    return read_beside_picture("<emitter type=\"envmap\">" + content + "</emitter>" + sphere("")).sky;
  };
  const auto picture =
      sky(R"(<texture name="albedo" type="png_texture"><string name="filename" value="a.hdr"/></texture>
                              <float name="scale" value="3"/>)");
  ASSERT_TRUE(picture.picture);
  EXPECT_EQ(picture.picture->scale, 3.0);
  EXPECT_EQ(picture.picture->bitmap->width, 2u);
  const auto brighter = sky(R"(<string name="path2map" value="a.hdr"/><color name="radiance" value="5"/>)");
  EXPECT_EQ(brighter.picture.value().scale, 5.0);
  for (const char* color : {R"(<texture type="constant"><color name="value" value="0.1 0.2 0.3"/></texture>)",
                            R"(<color name="radiance" value="0.1 0.2 0.3"/>)"}) {
    EXPECT_FALSE(sky(color).picture);
    EXPECT_EQ(sky(color).top, glm::dvec3(0.1, 0.2, 0.3));
    EXPECT_EQ(sky(color).horizon, sky(color).top);
  }
}

TEST(Courses, PicturesOfTheSkyThatMeanNothing) {
  const auto message = [](const std::string& content) {
    return all_messages(parse_beside_picture("<emitter type=\"envmap\">" + content + "</emitter>").diagnostics);
  };
  EXPECT_THAT(message(""), HasSubstr("<emitter type=\"envmap\"> needs its property \"filename\""));
  EXPECT_THAT(message(R"(<texture type="bitmap"/>)"), HasSubstr("<texture type=\"bitmap\"> needs its property"));
  EXPECT_THAT(message(R"(<texture type="checkerboard"/>)"), HasSubstr("a checkerboard is no picture of a sky"));
  EXPECT_THAT(message(R"(<string name="filename" value="a.hdr"/><color name="radiance" value="1 2 3"/>)"),
              HasSubstr("a picture of a sky takes a grey factor"));
  EXPECT_THAT(message(R"(<string name="filename" value="a.hdr"/><color name="radiance" value="0"/>)"),
              HasSubstr("the factor of a sky must be above 0"));
  EXPECT_THAT(message(R"(<string name="filename" value="a.hdr"/><texture type="constant"/>)"),
              HasSubstr("the sky has two pictures"));
}

TEST(Courses, SpotsInTheirWords) {
  const auto spot = [](const std::string& content) {
    return parse_beside_picture("<emitter type=\"spotlight\"><point name=\"position\" value=\"0 3 0\"/>" + content +
                                "</emitter>" + sphere(""));
  };
  const Parsed colored = spot(R"(<color name="color" value="12.566370614359172"/>
      <float name="cosFalloffStart" value="10"/><float name="cosTotalWidth" value="30"/>)");
  ASSERT_TRUE(colored.file) << all_messages(colored.diagnostics);
  const DeltaLight& light = colored.scene().delta_lights.at(0);
  EXPECT_NEAR(light.intensity.value.x, 1.0, 1e-12);
  EXPECT_EQ(light.falloff, DeltaLight::Falloff::linear);
  EXPECT_EQ(light.cutoff, 30.0);
  EXPECT_THAT(all_messages(spot(R"(<color name="color" value="1"/><color name="power" value="1"/>)").diagnostics),
              HasSubstr("the spot has both \"power\" and \"color\""));
  const Parsed hard = spot(R"(<color name="intensity" value="1"/><float name="falloffStart" value="50"/>
      <float name="totalWidth" value="30"/>)");
  ASSERT_TRUE(hard.file) << all_messages(hard.diagnostics);
  EXPECT_THAT(all_messages(hard.diagnostics), HasSubstr("the light ends with the cone, at a hard edge"));
  EXPECT_EQ(hard.scene().delta_lights.at(0).beam_width, 30.0);
}

TEST(Courses, Parallelograms) {
  const Scene scene = read_beside_picture(R"(<mesh type="parallelogram"><point name="origin" value="1 2 3"/>
      <vector name="u" value="0 0 4"/><vector name="v" value="5 0 0"/>
      <emitter type="parallelogram_emitter"><color name="radiance" value="1"/></emitter></mesh>)");
  const auto& mesh = std::get<TriangleMesh>(scene.shapes.at(0));
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(glm::dvec3(mesh.positions[0]), glm::dvec3(1, 2, 3));
  EXPECT_EQ(glm::dvec3(mesh.positions[2]), glm::dvec3(6, 2, 7));
  EXPECT_EQ(mesh.uv_sets.at(0)[2], glm::vec2(1.0f));
  const glm::dvec3 a(mesh.positions[0]), b(mesh.positions[1]), c(mesh.positions[2]);
  EXPECT_GT(glm::cross(b - a, c - a).y, 0.0) << "u × v";
  EXPECT_TRUE(scene.instances.at(0).emitter.has_value());
}

/// Reading goes on after the report, with something in its place.
TEST(Courses, RequiredNumbersThatAreMissing) {
  const Parsed lens =
      parse(R"(<scene><integrator type="path"/><camera type="thinlens"/><mesh type="sphere"/></scene>)");
  EXPECT_FALSE(lens.file);
  EXPECT_THAT(all_messages(lens.diagnostics),
              HasSubstr("<camera type=\"thinlens\"> needs its property \"focusDistance\""));
  const Parsed av = parse(R"(<scene><integrator type="av"/><camera type="perspective"/><mesh type="sphere"/></scene>)");
  EXPECT_FALSE(av.file);
  EXPECT_THAT(all_messages(av.diagnostics), HasSubstr("needs its property \"length\""));
}

TEST(Courses, DisneysMaterialWithoutHighlights) {
  const Scene scene = read_beside_picture(sphere(R"(<bsdf type="disney"><float name="specular" value="0"/></bsdf>)"));
  const double eta = std::get<PrincipledBsdf>(scene.materials.at(0).bsdf).eta.value;
  EXPECT_GT(eta, 1.001);
  EXPECT_LT(eta, 1.002);
}

TEST(Courses, WhatThereIsNotIsReplacedWhereThatIsWanted) {
  const std::string text =
      R"(<scene><integrator type="single_scattering"/><camera type="perspective"/><medium type="homogeneous"/>
         <mesh type="sphere"><bsdf type="bssrdf"><color name="albedo" value="0.4 0.2 0.1"/></bsdf></mesh>
         <mesh type="sphere"><bsdf type="diffuse"><texture type="perlin" name="albedo"/></bsdf></mesh></scene>)";
  const Parsed refused = parse(text);
  EXPECT_FALSE(refused.file);
  EXPECT_THAT(all_messages(refused.diagnostics),
              HasSubstr("the scene needs things that are not supported: bsdf bssrdf (2:"));
  for (const char* feature : {"integrator single_scattering (1:", "medium homogeneous (1:", "texture perlin (3:"})
    EXPECT_THAT(all_messages(refused.diagnostics), HasSubstr(feature));
  ReadOptions options;
  options.approximate = true;
  const Parsed replaced = parse(text, options);
  ASSERT_TRUE(replaced.file) << all_messages(replaced.diagnostics);
  const Scene& scene = replaced.scene();
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.materials.at(0).bsdf).albedo.value, glm::dvec3(0.4, 0.2, 0.1));
  EXPECT_EQ(std::get<DiffuseBsdf>(scene.materials.at(1).bsdf).albedo.value, glm::dvec3(0.5));
  EXPECT_EQ(scene.integrator.type, Integrator::Type::path);
  EXPECT_THAT(scene.approximations,
              ElementsAre("medium: left out", "integrator single_scattering: path_mis",
                          "bsdf bssrdf: diffuse, of its colour or grey", "texture perlin: grey, 0.5"));
  EXPECT_THAT(all_messages(replaced.diagnostics), Not(HasSubstr("error")));
}

TEST(Courses, NamesOfPicturesInPlaceOfColours) {
  const Parsed parsed = parse_beside_picture(
      sphere(R"(<bsdf type="diffuse"><color name="albedo" value="0.1 0.2 0.3"/>
                  <string name="texture_file" value="a.hdr"/></bsdf>)") +
      sphere(R"(<bsdf type="diffuse"><texture type="bitmap"><string name="filename" value="a.hdr"/></texture>
                  <color name="albedo" value="0.1 0.2 0.3"/></bsdf>)") +
      sphere(R"(<bsdf type="disney"><string name="base_color" value="a.hdr"/>
                  <string name="roughness_texture" value="a.hdr"/></bsdf>)"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  const Scene& scene = parsed.scene();
  for (const std::size_t i : {0u, 1u})
    EXPECT_TRUE(std::get<DiffuseBsdf>(scene.materials.at(i).bsdf).albedo.texture.has_value()) << i;
  EXPECT_TRUE(std::get<PrincipledBsdf>(scene.materials.at(2).bsdf).base_color.texture.has_value());
  EXPECT_TRUE(std::get<PrincipledBsdf>(scene.materials.at(2).bsdf).roughness.texture.has_value());
  EXPECT_THAT(
      all_messages(parsed.diagnostics),
      HasSubstr("\"albedo\" of <bsdf type=\"diffuse\"> is given by a picture and by a value; the picture counts"));
  // Two values, or two pictures, are still one too many.
  const std::string name = R"(<string name="texture" value="a.hdr"/>)";
  const Parsed twice = parse_beside_picture(sphere("<bsdf type=\"diffuse\">" + name + name + "</bsdf>"));
  EXPECT_THAT(all_messages(twice.diagnostics), HasSubstr("\"albedo\""));
  const Parsed none =
      parse_beside_picture(sphere(R"(<bsdf type="diffuse"><string name="albedo" value="none.hdr"/></bsdf>)"));
  EXPECT_THAT(all_messages(none.diagnostics), HasSubstr("none.hdr: cannot open it"));
  EXPECT_FALSE(none.file);
}

TEST(Courses, MapsBesideTheirNumbers) {
  const Scene scene = read_beside_picture(sphere(R"(<bsdf type="disney"><texture type="image_texture_float"
      name="roughnessMap"><string name="filename" value="a.hdr"/></texture><float name="roughness" value="1"/>
      <float name="metallic" value="0.5"/><texture type="image_texture_float" name="metallicmap">
        <string name="filename" value="a.hdr"/></texture></bsdf>)"));
  const auto& material = std::get<PrincipledBsdf>(scene.materials.at(0).bsdf);
  EXPECT_TRUE(material.roughness.texture.has_value());
  EXPECT_TRUE(material.metallic.texture.has_value());
  const Parsed twice = parse_beside_picture(
      sphere(R"(<bsdf type="diffuse"><color name="albedo" value="0.5"/><texture type="solid" name="albedo"/></bsdf>)"));
  EXPECT_THAT(all_messages(twice.diagnostics), HasSubstr("is given twice"));
}

TEST(Courses, NormalsAndHolesOfMaterials) {
  const Scene scene = read_beside_picture(sphere(R"(<bsdf type="diffuse"><string name="normalMap" value="a.hdr"/>
      <float name="opacity" value="0.25"/></bsdf>)"));
  const auto& mask = std::get<MaskAdapter>(scene.materials.at(scene.instances.at(0).material).adapter.value());
  EXPECT_EQ(mask.opacity.value, 0.25);
  const auto& normals = std::get<NormalMapAdapter>(scene.materials.at(mask.inner).adapter.value());
  EXPECT_TRUE(normals.normals.texture.has_value());
  EXPECT_FALSE(normals.turned.mirrored);
  EXPECT_FALSE(normals.turned.shadowed);
  EXPECT_TRUE(std::holds_alternative<DiffuseBsdf>(scene.materials.at(normals.inner).bsdf));
}

TEST(Courses, MixturesCountTheFirst) {
  const std::string two = R"(<float name="weight" value="0.25"/><bsdf type="mirror"/><bsdf type="diffuse"/></bsdf>)";
  const auto share_of_mirror = [&](const std::string& type) {
    const Scene scene = read_beside_picture(sphere("<bsdf type=\"" + type + "\">" + two));
    const auto& blend = std::get<BlendAdapter>(scene.materials.at(scene.instances.at(0).material).adapter.value());
    const bool is_second = std::holds_alternative<MirrorBsdf>(scene.materials.at(blend.second).bsdf);
    return is_second ? blend.weight.value : 1.0 - blend.weight.value;
  };
  EXPECT_EQ(share_of_mirror("mixture"), 0.25);
  EXPECT_EQ(share_of_mirror("blend"), 0.75);
}

TEST(Courses, ColouredMirrors) {
  const Scene scene =
      read_beside_picture(sphere(R"(<bsdf type="mirror"><color name="color" value="0.9 0.8 0.7"/></bsdf>)") +
                          sphere(R"(<bsdf type="mirror"/>)"));
  const auto& tinted = std::get<ConductorBsdf>(scene.materials.at(0).bsdf);
  EXPECT_EQ(tinted.specular_reflectance.value, glm::dvec3(0.9, 0.8, 0.7));
  EXPECT_EQ(tinted.index.eta.value, glm::dvec3(0.0));
  EXPECT_TRUE(std::holds_alternative<MirrorBsdf>(scene.materials.at(1).bsdf));
}

TEST(Courses, FactorsOfTextureCoordinates) {
  const Scene scene = read_beside_picture(
      sphere(
          R"(<bsdf type="diffuse"><texture type="checkerboard"><float name="uvscale" value="20"/></texture></bsdf>)") +
      sphere(R"(<bsdf type="diffuse"><texture type="bitmap"><string name="filename" value="a.hdr"/>
                  <float name="uvscale" value="3"/></texture></bsdf>)"));
  EXPECT_EQ(scene.textures.at(0).uv_transform * glm::dvec3(1, 1, 1), glm::dvec3(20, 20, 1));
  EXPECT_EQ(scene.textures.at(1).uv_transform * glm::dvec3(1, 2, 1), glm::dvec3(3, 6, 1));
}

TEST(Courses, CheckersByTheirNumber) {
  const auto checker = [](const std::string& content) {
    return parse_beside_picture(
        sphere("<bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"checker\">" + content + "</texture></bsdf>"));
  };
  const Parsed parsed = checker(R"(<integer name="scalex" value="100"/><integer name="scaley" value="50"/>)");
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  const Texture& texture = parsed.scene().textures.at(0);
  EXPECT_EQ(std::get<CheckerboardTexture>(texture.source).color0, glm::dvec3(0.9));
  // The table's own squares have sides of 1/2.
  const glm::dvec3 at = texture.uv_transform * glm::dvec3(1, 1, 1);
  EXPECT_NEAR(at.x, 50.0, 1e-9);
  EXPECT_NEAR(at.y, 25.0, 1e-9);
  EXPECT_THAT(all_messages(checker(R"(<integer name="scalex" value="0"/>)").diagnostics), HasSubstr("0 squares"));
}

TEST(Courses, CosinesAndFullAnglesOfSpots) {
  const auto spot = [](const std::string& content) {
    return read_beside_picture("<emitter type=\"spot\">" + content + "</emitter>" + sphere("")).delta_lights.at(0);
  };
  const DeltaLight cosines = spot(R"(<color name="power" value="1"/><float name="cosTotalWidth" value="0.5"/>
      <float name="cosFalloffStart" value="0.8660254037844386"/>)");
  EXPECT_NEAR(cosines.cutoff, 60.0, 1e-9);
  EXPECT_NEAR(cosines.beam_width, 30.0, 1e-9);
  EXPECT_EQ(cosines.falloff, DeltaLight::Falloff::quartic);
  const DeltaLight full = spot(R"(<color name="power" value="7"/><float name="theta" value="60"/>
      <float name="thetaFalloff" value="20"/>)");
  EXPECT_EQ(full.cutoff, 30.0);
  EXPECT_EQ(full.beam_width, 10.0);
  EXPECT_EQ(full.falloff, DeltaLight::Falloff::linear);
  EXPECT_EQ(full.intensity.value, glm::dvec3(7.0));
  const DeltaLight half = spot(R"(<color name="power" value="7"/><float name="thetaMax" value="30"/>
      <float name="thetaFall" value="10"/>)");
  EXPECT_EQ(half.cutoff, 30.0);
  const DeltaLight turned = spot(R"(<point name="position" value="1 2 3"/><float name="thetaMax" value="30"/>
      <color name="power" value="1"/><transform name="toWorld"><rotate axis="1,0,0" angle="90"/></transform>)");
  EXPECT_EQ(turned.origin(), glm::dvec3(1, 2, 3));
  EXPECT_NEAR(glm::dvec3(turned.world_from_light[2]).y, 1.0, 1e-12);  // -Z is turned to +Y
  EXPECT_EQ(half.beam_width, 10.0);
  EXPECT_EQ(half.intensity.value, glm::dvec3(7.0));
}

TEST(Courses, WordsForWidthsOfLightsAreNotGuessed) {
  const Parsed wide = parse_beside_picture(R"(<emitter type="directional"><vector name="direction" value="0 -1 0"/>
      <color name="radiance" value="1"/><float name="angle" value="2"/></emitter>)" +
                                           sphere(""));
  EXPECT_FALSE(wide.file);
  EXPECT_THAT(all_messages(wide.diagnostics),
              HasSubstr("\"angle\" of <emitter type=\"directional\"> is not supported"));
}

TEST(Courses, SpheresTurnInPlace) {
  const auto center = [](const std::string& transform) {
    const Scene scene = read_beside_picture(
        "<mesh type=\"sphere\"><point name=\"center\" value=\"1 2 3\"/>"
        "<transform name=\"toWorld\">" +
        transform + "</transform></mesh>");
    const glm::dvec4 at(std::get<Sphere>(scene.shapes.at(0)).center, 1.0);
    return glm::dvec3(scene.instances.at(0).world_from_object * at);
  };
  const auto near = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b) < 1e-9; };
  const std::string turn = R"(<rotate axis="0,0,1" angle="90"/>)";
  EXPECT_TRUE(near(center(turn), glm::dvec3(1, 2, 3)));
  EXPECT_TRUE(near(center(turn + R"(<translate value="0,0,1"/>)"), glm::dvec3(-2, 1, 4)));
  EXPECT_TRUE(near(center(R"(<matrix value="0 -1 0 0  1 0 0 0  0 0 1 0  0 0 0 1"/>)"), glm::dvec3(-2, 1, 3)));
}

TEST(Courses, TheAxisUpOfTheSky) {
  const std::string picture = R"(<emitter type="envmap"><string name="filename" value="a.hdr"/>)";
  const auto up = [&](const std::string& content) {
    const Scene scene = read_beside_picture(content + sphere(""));
    return scene.sky.world_from_sky * glm::dvec3(0, 1, 0);  // of the upper edge
  };
  const auto near = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::length(a - b) < 1e-9; };
  const std::string turn = R"(<transform name="toWorld"><rotate axis="1,0,0" angle="-90"/></transform>)";
  EXPECT_EQ(up(picture + "</emitter>"), glm::dvec3(0, 1, 0));
  EXPECT_EQ(up(picture + R"(<string name="up" value="z"/></emitter>)"), glm::dvec3(0, 0, 1));
  EXPECT_EQ(up("<mesh type=\"sphere\">" + picture + "</emitter></mesh>"), glm::dvec3(0, 0, 1));
  EXPECT_TRUE(near(up(picture + turn + "</emitter>"), glm::dvec3(0, 1, 0)));
  EXPECT_TRUE(near(up(picture + turn + R"(<string name="up" value="y"/></emitter>)"), glm::dvec3(0, 0, -1)));
  // A camera with +Z up sees a horizon that lies down.
  const TemporaryFolder folder;
  folder.write("a.hdr", kPicture);
  for (const bool level : {false, true}) {
    Parsed standing;
    standing.file = parse_scene_file(
        R"(<scene><integrator type="path"/><camera type="perspective"><transform name="toWorld"><lookat origin="0,-5,1"
           target="0,0,0" up="0,0,1"/></transform></camera><mesh type="sphere"/>)" +
            picture + (level ? turn : "") + "</emitter></scene>",
        folder.path("s.xml"), {}, load_triangle, standing.diagnostics);
    const glm::dvec3 edge = standing.scene().sky.world_from_sky * glm::dvec3(0, 1, 0);
    EXPECT_TRUE(near(edge, level ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1)));
  }
  const Scene scene = read_beside_picture(picture + R"(<string name="up" value="z"/></emitter>)" + sphere(""));
  // The middle of the picture is toward -Z of the sky, its left edge toward +Z, a quarter toward ±X.
  EXPECT_EQ(scene.sky.world_from_sky * glm::dvec3(0, 0, 1), glm::dvec3(-1, 0, 0));
  EXPECT_THAT(all_messages(parse_beside_picture(picture + R"(<string name="up" value="x"/></emitter>)").diagnostics),
              HasSubstr("\"x\" is no axis toward the upper edge of the picture; use y or z"));
}

TEST(Courses, TheSkyOfASceneWithoutAnIntegrator) {
  const TemporaryFolder folder;
  folder.write("a.hdr", kPicture);
  const auto read = [&](const std::string& content) {
    Parsed result;
    result.file =
        parse_scene_file("<scene><camera type=\"perspective\"/><mesh type=\"sphere\"/>" + content + "</scene>",
                         folder.path("s.xml"), {}, load_triangle, result.diagnostics);
    return result;
  };
  const std::string sky = R"(<string name="envmap" value="a.hdr"/>)";
  const Parsed parsed = read(sky + R"(<float name="envmapScale" value="3"/>)");
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr("the scene has no integrator; it is rendered with path_mis"));
  ASSERT_TRUE(parsed.scene().sky.picture);
  EXPECT_EQ(parsed.scene().sky.picture->scale, 3.0);
  EXPECT_FALSE(read(sky + R"(<float name="envmapScale" value="0"/>)").scene().sky.picture);
  EXPECT_THAT(all_messages(read("").diagnostics), HasSubstr("<scene> needs a <integrator>"));
  EXPECT_THAT(all_messages(read(sky + R"(<color name="sky_top" value="1"/>)").diagnostics),
              HasSubstr("\"envmap\" and another sky are two; keep one of them"));
}

TEST(Courses, CamerasWhoseLensIsOff) {
  const auto type = [](const std::string& dof) {
    return parse(
               "<scene><integrator type=\"path\"/><camera type=\"perspective\"><float name=\"apertureRadius\" "
               "value=\"0.1\"/><float name=\"focusDistance\" value=\"3\"/><boolean name=\"DOF\" value=\"" +
               dof + "\"/></camera><mesh type=\"sphere\"/></scene>")
        .scene()
        .camera.type;
  };
  EXPECT_EQ(type("true"), Camera::Type::thin_lens);
  EXPECT_EQ(type("false"), Camera::Type::perspective);
}

TEST(Courses, WhatChangesNothingIsPassedOver) {
  ReadOptions strict;
  strict.strict = true;
  const Parsed parsed = parse(
      R"(<scene><rendermanager type="blockwise"/><integrator type="photonmapper"><integer name="photonCount" value="9"/>
         </integrator><camera type="perspective"><boolean name="motionBlur" value="false"/>
           <float name="distortion" value="0.0"/></camera><mesh type="sphere"/></scene>)",
      strict);
  EXPECT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr("it changes the noise, not the picture"));
  EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr("it says that there is no motion blur"));
}

TEST(Courses, WhatChangesThePictureIsRefusedAllAtOnce) {
  const std::string text =
      R"(<scene><integrator type="path"/><camera type="perspective"><float name="distortion" value="0.1"/></camera>
         <subscene type="group"><medium type="fog"><phase type="hg"/></medium></subscene>
         <mesh type="sphere"><bsdf type="layered"><bsdf type="velvet"/></bsdf></mesh></scene>)";
  const Parsed refused = parse(text);
  EXPECT_FALSE(refused.file);
  for (const char* feature : {"distortion of camera (1:", "subscene group (2:", "medium fog (2:", "phase hg (2:",
                              "bsdf layered (3:", "bsdf velvet (3:"})
    EXPECT_THAT(to_string(refused.diagnostics.list().at(0)), HasSubstr(feature));
  EXPECT_THAT(
      all_messages(refused.diagnostics),
      HasSubstr("\"distortion\" of <camera type=\"perspective\"> is not supported: there is no lens distortion"));
  // Without the unknown tag, substitutes do.
  ReadOptions options;
  options.approximate = true;
  const Parsed replaced = parse(
      R"(<scene><integrator type="path"/><camera type="perspective"><float name="distortion" value="0.1"/></camera>
         <mesh type="sphere"/></scene>)",
      options);
  ASSERT_TRUE(replaced.file) << all_messages(replaced.diagnostics);
  EXPECT_THAT(replaced.scene().approximations, ElementsAre("distortion of camera: left out"));
}

TEST(Courses, UnknownPropertiesAreListedByCheck) {
  const std::string text = R"(<scene><integrator type="path"/><camera type="perspective"/>
      <mesh type="sphere"><bsdf type="diffuse"><float name="fuzz" value="1"/><float name="shine" value="1"/></bsdf></mesh></scene>)";
  ReadOptions strict;
  strict.strict = true;
  EXPECT_THAT(
      all_messages(parse(text, strict).diagnostics),
      HasSubstr(
          "the scene needs things that are not supported: fuzz of bsdf diffuse (2:61); shine of bsdf diffuse (2:"));
  EXPECT_TRUE(parse(text).file);
}

}  // namespace
}  // namespace etendue::testing
