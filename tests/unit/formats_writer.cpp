/// Scenes that are written and read again are the same to the last bit.

#include <cstring>
#include <filesystem>

#include "core/errors.h"
#include "formats/mitsuba/mitsuba_writer.h"
#include "formats/nori/nori_writer.h"
#include "formats_testing.h"
#include "image/files.h"

namespace etendue::testing {
namespace {

std::shared_ptr<Bitmap> bitmap(BitmapFormat format, std::uint32_t channels, ColorSpace color_space) {
  auto picture = std::make_shared<Bitmap>();
  picture->width = 3;
  picture->height = 2;
  picture->channels = channels;
  picture->format = format;
  picture->color_space = color_space;
  picture->texels.resize(picture->row_bytes() * 2);
  for (std::size_t i = 0; i < picture->texels.size() / bytes_of(format); ++i) {
    const auto code = static_cast<std::uint16_t>(3001 * i + 17);
    const float number = color_space == ColorSpace::srgb ? static_cast<float>(code) / 65535.0f : 0.125f * code;
    const std::uint16_t half = static_cast<std::uint16_t>(0x3000 + i);
    const std::uint8_t byte = static_cast<std::uint8_t>(37 * i + 5);
    const void* from = format == BitmapFormat::u8    ? static_cast<const void*>(&byte)
                       : format == BitmapFormat::f16 ? static_cast<const void*>(&half)
                                                     : static_cast<const void*>(&number);
    std::memcpy(&picture->texels[i * bytes_of(format)], from, bytes_of(format));
  }
  return picture;
}

TriangleMesh mesh() {
  TriangleMesh mesh{
      .positions = {{0.1, 0, 0}, {1, 1.0 / 3.0, 0}, {0, 1, 0.7}}, .normals = {}, .triangles = {{0, 1, 2}}};
  for (int i = 0; i < 3; ++i) mesh.normals.push_back(glm::normalize(glm::dvec3(0.3 * i + 0.1, 0.2, 1)));
  mesh.uv_sets.push_back({{0.1f, 0.2f}, {3.3f, -0.2f}, {0.5f, 0.7f}});
  mesh.vertex_colors = {{0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}, {0.7f, 0.8f, 0.9f}};
  mesh.face_colors = {{0.3f, 0.2f, 0.1f}};
  return mesh;
}

void add_textures(Scene& scene) {
  scene.bitmaps = {bitmap(BitmapFormat::u8, 3, ColorSpace::srgb), bitmap(BitmapFormat::f32, 1, ColorSpace::linear),
                   bitmap(BitmapFormat::f16, 4, ColorSpace::linear), bitmap(BitmapFormat::f32, 3, ColorSpace::srgb)};
  const glm::dmat3 turned(0.3, 0.1, 0.0, -0.2, 1.7, 0.0, 1.0 / 3.0, 0.6, 1.0);
  for (std::uint32_t i = 0; i < scene.bitmaps.size(); ++i)
    scene.textures.push_back({.source = BitmapTexture{.bitmap = i,
                                                      .wrap_u = static_cast<TextureWrap>(i % 3),
                                                      .wrap_v = static_cast<TextureWrap>(i % 3),
                                                      .filter = static_cast<TextureFilter>(i % 2),
                                                      .color_space = {}},
                              .uv_transform = turned});
  std::get<BitmapTexture>(scene.textures[0].source).color_space = ColorSpace::linear;
  scene.textures.push_back(
      {.source = CheckerboardTexture{{0.1, 0.2, 0.3}, {0.7, 1.0 / 7.0, 0.2}}, .uv_transform = turned});
  scene.textures.push_back({.source = AttributeTexture{AttributeTexture::Source::face_color}});
}

void add_instances(Scene& scene) {
  const auto textured = [](std::uint32_t row) { return DiffuseBsdf{ColorParameter(glm::dvec3(1.0), row)}; };
  for (std::uint32_t row = 0; row < 6; ++row) {
    Instance& instance = scene.add(mesh(), textured(row));
    instance.world_from_object[3] = glm::dvec4(1.0 / 3.0, 2, row, 1);
    instance.flip_normals = row % 2 == 1;
  }
  Instance& lamp = scene.add(Disk{}, MirrorBsdf{}, AreaEmitter{ColorParameter(glm::dvec3(3.0, 2.0, 0.1), 4)});
  lamp.world_from_object = glm::dmat4({1, 0.5, 0.3, 0}, {0, 0.6, 0, 0}, {0, 0, -1, 0}, {0, 0, 2, 1});
  scene.add(Sphere{{1, 2, 3}, 0.7}, RoughDielectricBsdf{1.5, 1.0, {}, {1, 1, 0.9}, {0.9, 1, 1}});
  scene.add(Cylinder{{1, 2, 3}, {2, 3, 5}, 0.1}, PlasticBsdf{});
  scene.add(Disk{}, RoughPlasticBsdf{.nonlinear = true});
  scene.add(Disk{}, MicrofacetBsdf{.kd = {0.1, 0.2, 0.3}});
  scene.add(Disk{}, ConductorBsdf{{{0.2, 0.3, 1.0 / 3.0}, {3, 2, 1}}, {1, 1, 1}});
  scene.add(Disk{}, RoughConductorBsdf{{}, {Roughness::Distribution::ggx, 0.2, 1.0 / 30.0}, {0.8, 1, 1}});
  scene.add(Disk{}, ThinDielectricBsdf{});
  scene.add(Disk{}, DielectricBsdf{});
  scene.instances.push_back(scene.instances.back());  // shared material and shape
}

Camera lens_camera() {
  Camera camera;
  camera.type = Camera::Type::thin_lens;
  camera.width = 30;
  camera.height = 7;
  camera.window = {{0.1, 2.0 / 9.0}, {0.3, 7.0 / 9.0}, {0.01, -0.2}};
  camera.aperture = {0.1, 7.0 / 3.0, 5, 12.0};
  camera.fov_axis = Camera::FovAxis::diagonal;
  camera.filter = {.type = ReconstructionFilter::Type::mitchell, .b = 0.1, .c = 1.0 / 7.0};
  camera.world_from_camera[3] = glm::dvec4(0.1, 0.2, 1.0 / 3.0, 1);
  return camera;
}

void add_lights(Scene& scene) {
  scene.sky.picture = {.bitmap = bitmap(BitmapFormat::f32, 3, ColorSpace::linear),
                       .scale = 1.0 / 3.0,
                       .rows = SkyPicture::Rows::circles};
  scene.sky.world_from_sky = glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1});
  const glm::dmat4 turned_light({0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1.0 / 3.0, 0.2, 0.3, 1});
  scene.delta_lights.push_back({.intensity = glm::dvec3(0.1, 1.0 / 3.0, 2.0), .world_from_light = turned_light});
  scene.delta_lights.push_back({.type = DeltaLight::Type::spot,
                                .intensity = ColorParameter(glm::dvec3(1.0), 0),
                                .world_from_light = turned_light,
                                .cutoff = 33.0,
                                .beam_width = 7.0,
                                .falloff = DeltaLight::Falloff::smooth});
  scene.delta_lights.push_back(
      {.type = DeltaLight::Type::directional, .intensity = glm::dvec3(3.0), .world_from_light = turned_light});
}

/// A scene with something of everything.
Scene everything() {
  Scene scene;
  scene.name = "everything";
  add_textures(scene);
  add_instances(scene);
  scene.camera = lens_camera();
  scene.sampler = {Sampler::Type::sobol, 64, 3};
  scene.integrator.max_depth = 5;
  scene.integrator.hide_emitters = true;
  scene.integrator.hide_background = true;
  scene.aovs = {Aov::depth, Aov::albedo};
  add_lights(scene);
  return scene;
}

TEST(SceneWriter, WhatIsReadAgainIsTheSameScene) {
  const TemporaryFolder folder;
  const Scene scene = everything();
  const std::string path = folder.path("s.xml");
  write_scene(path, scene);
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {.overrides = {}, .strict = true}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  EXPECT_EQ(all_messages(diagnostics), "");
  const Scene& read = std::get<Scene>(*file);
  EXPECT_EQ(read.instances.size(), scene.instances.size());
  EXPECT_EQ(read.integrator.max_depth, 5u);
  EXPECT_TRUE(read.integrator.hide_emitters);
  EXPECT_TRUE(read.integrator.hide_background);
  EXPECT_EQ(read.aovs, scene.aovs);
  EXPECT_EQ(read.sampler.set_bits, 3u);
  EXPECT_EQ(read.camera.window.origin, scene.camera.window.origin);
  EXPECT_EQ(read.camera.window.size, scene.camera.window.size);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(read.bitmaps.at(i)->texels, scene.bitmaps[i]->texels) << i;
    EXPECT_EQ(read.bitmaps.at(i)->format, scene.bitmaps[i]->format) << i;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const auto& a = std::get<TriangleMesh>(scene.shape_of(scene.instances[i]));
    const auto& b = std::get<TriangleMesh>(read.shape_of(read.instances[i]));
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.triangles, b.triangles);
    // The last one shows colours of faces, for which no texture coordinates are read.
    EXPECT_EQ(i < 5 ? a.uv_sets : std::vector<std::vector<glm::vec2>>{}, b.uv_sets);
    EXPECT_EQ(i == 5 ? a.face_colors : std::vector<glm::vec3>{}, b.face_colors);
    EXPECT_EQ(scene.instances[i].world_from_object, read.instances[i].world_from_object);
  }
  EXPECT_EQ(read.emitters.at(0).radiance.value, glm::dvec3(3.0, 2.0, 0.1));
  // Written once more it is the same text: everything is in it.
  const std::string again = folder.path("t.xml");
  write_scene(again, read);
  const auto text_of = [](const std::string& file_path) {
    const std::vector<std::byte> bytes = read_file(file_path);
    std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (std::size_t at = text.find("t-files/"); at != std::string::npos; at = text.find("t-files/")) text[at] = 's';
    return text;
  };
  EXPECT_EQ(text_of(path), text_of(again));
}

TEST(SceneWriter, SkiesThatAreTurnedAreReadAgain) {
  const TemporaryFolder folder;
  Scene scene = everything();
  scene.sky.world_from_sky = glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0});  // words of courses are not meant
  const std::string path = folder.path("s.xml");
  write_scene(path, scene);
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {.overrides = {}, .strict = true}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  EXPECT_EQ(all_messages(diagnostics), "");
  EXPECT_EQ(std::get<Scene>(*file).sky.world_from_sky, scene.sky.world_from_sky);
}

TEST(SceneWriter, EveryFilterIsReadAgain) {
  using Type = ReconstructionFilter::Type;
  for (const ReconstructionFilter& filter : {ReconstructionFilter{.type = Type::box, .stretch = 3.0},
                                             ReconstructionFilter{.type = Type::tent, .stretch = 0.7},
                                             ReconstructionFilter{.type = Type::gaussian, .radius = 1.3, .stddev = 0.4},
                                             ReconstructionFilter{.type = Type::lanczos, .lobes = 5}}) {
    const TemporaryFolder folder;
    Scene scene = everything();
    scene.camera.filter = filter;
    write_scene(folder.path("s.xml"), scene);
    const auto file = read_scene_file(folder.path("s.xml"), {.overrides = {}, .strict = true});
    const ReconstructionFilter& read = std::get<Scene>(file).camera.filter;
    EXPECT_EQ(read.type, filter.type);
    EXPECT_EQ(read.radius, filter.radius);
    EXPECT_EQ(read.stddev, filter.stddev);
    EXPECT_EQ(read.stretch, filter.stretch);
    EXPECT_EQ(read.lobes, filter.lobes);
  }
}

std::string text_of(const std::string& path) {
  const std::vector<std::byte> bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Adapters in one another, each before what refers to it, as they are read again.
Scene nested() {
  Scene scene;
  scene.bitmaps = {bitmap(BitmapFormat::u8, 3, ColorSpace::linear)};
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0, .color_space = {}}});
  ScalarParameter height{0.1};
  height.texture = 0;
  height.channel = TextureChannel::luminance;
  scene.materials = {{.bsdf = DiffuseBsdf{{0.1, 0.2, 0.3}}},
                     {.bsdf = MirrorBsdf{}},
                     {.adapter = TwoSidedAdapter{0, 1}},
                     {.adapter = MaskAdapter{{1.0 / 3.0}, 2}},
                     {.bsdf = PrincipledBsdf{.base_color = {0.2, 0.5, 0.7},
                                             .roughness = 0.6,
                                             .metallic = 0.1,
                                             .anisotropic = 0.4,
                                             .spec_tint = 0.3,
                                             .sheen = 0.5,
                                             .clearcoat = 0.9,
                                             .sheen_tint = 0.7,
                                             .flatness = 0.2,
                                             .clearcoat_gloss = 0.8,
                                             .eta = 1.4}},
                     {.adapter = BlendAdapter{{0.3}, 3, 4}},
                     {.adapter = BumpMapAdapter{height, 5}},
                     {.adapter = NormalMapAdapter{{glm::dvec3(1.0), 0}, 4}},
                     {.bsdf = NullBsdf{}}};
  scene.shapes.emplace_back(Sphere{});
  for (const std::uint32_t material : {6u, 7u, 8u}) scene.instances.push_back({.shape = 0, .material = material});
  return scene;
}

/// A ball of one material, whose roughness and sheen a picture says.
Scene ball_of(const Bsdf& bsdf) {
  Scene scene;
  scene.bitmaps = {bitmap(BitmapFormat::u8, 3, ColorSpace::linear)};
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0, .color_space = {}}});
  scene.add(Sphere{}, bsdf);
  return scene;
}

Scene copy_of(const Scene& scene, const std::string& path, bool mitsuba) {
  if (mitsuba)
    write_mitsuba_scene(path, scene);
  else
    write_scene(path, scene);
  Diagnostics diagnostics;
  auto file = read_scene_file(path, {.overrides = {}, .strict = true}, diagnostics);
  EXPECT_TRUE(file.has_value()) << all_messages(diagnostics);
  return std::get<Scene>(*file);
}

const ScalarParameter kFromPicture{0.5, 0, TextureChannel::green};

TEST(SceneWriter, SheetsComeBackFromBothDialects) {
  const TemporaryFolder folder;
  const Scene scene =
      ball_of(PrincipledThinBsdf{.base_color = {0.2, 0.5, 0.7}, .spec_trans = 0.25, .sheen = 0.5, .diff_trans = 1.5});
  for (const bool mitsuba : {false, true}) {
    const std::string name = mitsuba ? "m" : "e";
    std::filesystem::create_directory(folder.path(name));
    const Scene copy = copy_of(scene, folder.path(name + "/s.xml"), mitsuba);
    const auto& sheet = std::get<PrincipledThinBsdf>(copy.bsdf_of(copy.instances[0]));
    EXPECT_EQ(sheet.base_color.value, glm::dvec3(0.2, 0.5, 0.7));
    EXPECT_EQ(sheet.spec_trans.value, 0.25);
    EXPECT_EQ(sheet.diff_trans.value, 1.5);
    EXPECT_EQ(sheet.eta.value, 1.5);
  }
}

TEST(SceneWriter, GltfMaterialsComeBackWithTheirTextures) {
  const TemporaryFolder folder;
  GltfBsdf bsdf{.metallic = 0.25, .ior = 1.25, .transmission = 0.5, .sheen_color = {0.5, 0.25, 0.0}, .thin = false};
  bsdf.roughness = bsdf.sheen_roughness = kFromPicture;
  bsdf.attenuation_color = {0.5, 0.25, 1.0};
  bsdf.attenuation_distance = 2.0;
  bsdf.anisotropy_directions.texture = std::uint32_t{0};
  const Scene scene = ball_of(bsdf);
  const Scene copy = copy_of(scene, folder.path("s.xml"), false);
  const auto& back = std::get<GltfBsdf>(copy.bsdf_of(copy.instances[0]));
  EXPECT_EQ(back.ior.value, 1.25);
  EXPECT_EQ(back.transmission.value, 0.5);
  ASSERT_TRUE(back.roughness.texture && back.sheen_roughness.texture);
  EXPECT_EQ(back.roughness.channel, TextureChannel::green);
  EXPECT_FALSE(back.thin);
  EXPECT_EQ(back.attenuation_color, bsdf.attenuation_color);
  EXPECT_EQ(back.attenuation_distance, 2.0);
  EXPECT_TRUE(back.anisotropy_directions.texture);
}

TEST(SceneWriter, AdaptersAreWrittenWithWhatTheyStandBefore) {
  const TemporaryFolder folder;
  const std::string path = folder.path("1/s.xml"), again = folder.path("2/s.xml"), mitsuba = folder.path("3/s.xml");
  for (const char* name : {"1", "2", "3"}) std::filesystem::create_directory(folder.path(name));
  write_scene(path, nested());
  const auto read = [](const std::string& file_path) {
    Diagnostics diagnostics;
    auto file = read_scene_file(file_path, {.overrides = {}, .strict = true}, diagnostics);
    EXPECT_TRUE(file.has_value()) << all_messages(diagnostics);
    return std::get<Scene>(*file);
  };
  const Scene scene = read(path);
  ASSERT_EQ(scene.materials.size(), 9u);
  const auto& principled = std::get<PrincipledBsdf>(scene.materials[4].bsdf);
  EXPECT_EQ(principled.roughness.value, 0.6);
  EXPECT_EQ(principled.eta.value, 1.4);
  EXPECT_EQ(std::get<BlendAdapter>(*scene.materials[5].adapter).second, 4u);
  EXPECT_EQ(std::get<TwoSidedAdapter>(*scene.materials[2].adapter).back, 1u);
  write_scene(again, scene);
  EXPECT_EQ(text_of(path), text_of(again));
  write_mitsuba_scene(mitsuba, nested());
  const Scene there = read(mitsuba);
  ASSERT_EQ(there.instances.size(), 3u);
  const auto& bumps = std::get<BumpMapAdapter>(*there.materials[there.instances[0].material].adapter);
  EXPECT_EQ(bumps.height.value, 0.1);
  const auto& blend = std::get<BlendAdapter>(*there.materials[bumps.inner].adapter);
  EXPECT_EQ(blend.weight.value, 0.3);
  EXPECT_TRUE(std::holds_alternative<MaskAdapter>(*there.materials[blend.first].adapter));
}

TEST(SceneWriter, CheckerboardsOfTexturesAndLooseMapsComeBackFromBothDialects) {
  const TemporaryFolder folder;
  Scene scene = ball_of(DiffuseBsdf{ColorParameter(glm::dvec3(0.5), 1)});
  CheckerboardTexture board{{0.5, 1.0, 1.0}, {0.2, 0.3, 0.4}};
  board.texture0 = 0;
  scene.textures.push_back({.source = board});
  scene.materials.push_back(
      {.bsdf = DiffuseBsdf{}, .adapter = NormalMapAdapter{{glm::dvec3(1.0), 0}, 0, false, {false, false}}});
  scene.instances[0].material = 1;
  for (const bool mitsuba : {false, true}) {
    const std::string name = mitsuba ? "m" : "e";
    std::filesystem::create_directory(folder.path(name));
    const Scene copy = copy_of(scene, folder.path(name + "/s.xml"), mitsuba);
    const auto& map = std::get<NormalMapAdapter>(copy.materials[copy.instances[0].material].adapter.value());
    EXPECT_EQ(map.turned, (TurnedNormals{.mirrored = false, .shadowed = false}));
    const ColorParameter& albedo = std::get<DiffuseBsdf>(copy.materials[map.inner].bsdf).albedo;
    const auto& there = std::get<CheckerboardTexture>(copy.textures[albedo.texture.value()].source);
    ASSERT_TRUE(there.texture0.has_value());
    EXPECT_FALSE(there.texture1.has_value());
    EXPECT_TRUE(std::holds_alternative<BitmapTexture>(copy.textures[*there.texture0].source));
    EXPECT_NEAR(glm::distance(albedo.value * there.color1, 0.5 * board.color1), 0.0, 1e-7);
  }
}

TEST(SceneWriter, MitsubaGetsAChannelAsAPictureOfItsOwn) {
  const TemporaryFolder folder;
  Scene scene;
  scene.bitmaps = {bitmap(BitmapFormat::u8, 4, ColorSpace::linear)};
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0}});
  PrincipledBsdf bsdf;
  bsdf.roughness = {0.5, 0, TextureChannel::green};
  bsdf.metallic = {1.0, 0, TextureChannel::blue};
  scene.add(mesh(), bsdf);
  write_mitsuba_scene(folder.path("s.xml"), scene);
  Diagnostics diagnostics;
  const auto file = read_scene_file(folder.path("s.xml"), {.strict = true}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  const Scene& read = std::get<Scene>(*file);
  const auto& there = std::get<PrincipledBsdf>(read.bsdf_of(read.instances.at(0)));
  const auto stored = [&](const ScalarParameter& parameter) {
    const auto& source = std::get<BitmapTexture>(read.textures.at(*parameter.texture).source);
    return static_cast<float>(parameter.value) * read.bitmaps.at(source.bitmap)->stored(2, 1, 0);
  };
  EXPECT_FLOAT_EQ(stored(there.roughness), 0.5f * scene.bitmaps[0]->stored(2, 1, 1));
  EXPECT_FLOAT_EQ(stored(there.metallic), scene.bitmaps[0]->stored(2, 1, 2));
}

TEST(SceneWriter, FilesThatExistAreReplacedOnlyWhenAsked) {
  const TemporaryFolder folder;
  const Scene scene = everything();
  const std::string other = folder.write("s-files/mesh-1.ply", "mine");
  EXPECT_THROW(write_scene(folder.path("s.xml"), scene), Error);
  EXPECT_EQ(read_file(other).size(), 4u);
  const auto files = std::filesystem::recursive_directory_iterator(folder.path(""));
  EXPECT_EQ(std::distance(begin(files), end(files)), 2) << "the folder and the file that were there";
  write_scene(folder.path("s.xml"), scene, ExistingFiles::replace);
  EXPECT_GT(read_file(other).size(), 4u);
}

TEST(SceneWriter, WhatFailsHalfwayLeavesNothing) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("s.xml"));  // so that the last file cannot be written
  EXPECT_THROW(write_scene(folder.path("s.xml"), everything(), ExistingFiles::replace), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path("s.xml")));
  EXPECT_FALSE(std::filesystem::exists(folder.path("s-files")));
}

TEST(SceneWriter, MitsubaIsToldWhatItCanSay) {
  const TemporaryFolder folder;
  Scene scene = everything();
  const std::string path = folder.path("s.xml");
  EXPECT_THROW(write_mitsuba_scene(path, scene), Error);  // Nori's microfacet
  EXPECT_TRUE(std::filesystem::is_empty(folder.path(""))) << "pictures and meshes of a scene that was refused";
  for (Material& material : scene.materials) {
    if (std::holds_alternative<MicrofacetBsdf>(material.bsdf)) material.bsdf = DiffuseBsdf{};
  }
  scene.camera.world_from_camera = glm::dmat4(1.0);
  scene.aovs.push_back(Aov::material);
  const std::vector<std::string> differences = write_mitsuba_scene(path, scene);
  // The polygonal aperture, how the spot fades, the hidden background, numbers of materials.
  EXPECT_EQ(differences.size(), 4u);
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {.overrides = {}, .strict = true}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  const Scene& read = std::get<Scene>(*file);
  ASSERT_EQ(read.instances.size(), scene.instances.size());
  EXPECT_EQ(read.aovs, (std::vector{Aov::depth, Aov::albedo}));
  EXPECT_EQ(read.camera.aperture.radius, 0.1);
  EXPECT_EQ(read.camera.filter.b, scene.camera.filter.b);
  for (std::size_t i = 0; i < 5; ++i) {
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row)
        EXPECT_NEAR(read.textures.at(i).uv_transform[column][row], scene.textures[i].uv_transform[column][row], 1e-15);
    }
    const auto& a = std::get<TriangleMesh>(scene.shape_of(scene.instances[i]));
    const auto& b = std::get<TriangleMesh>(read.shape_of(read.instances[i]));
    EXPECT_EQ(a.uv_sets, b.uv_sets);
    // What is flipped is a mesh inside out there.
    const bool flipped = scene.instances[i].flip_normals;
    EXPECT_FALSE(read.instances[i].flip_normals);
    EXPECT_EQ(b.triangles.at(0), flipped ? glm::uvec3(0, 2, 1) : glm::uvec3(0, 1, 2));
    EXPECT_EQ(b.normals.at(1), flipped ? -a.normals[1] : a.normals[1]);
  }
}

/// Mitsuba joins the meshes of one material, and fails where only some are flipped.
TEST(SceneWriter, MitsubaGetsMirroredMeshesInsideOut) {
  const TemporaryFolder folder;
  Scene scene;
  TriangleMesh flat = mesh();
  flat.normals.clear();
  scene.add(flat, DiffuseBsdf{});
  Instance mirrored = scene.instances[0];
  mirrored.world_from_object[0][0] = -1.0;
  scene.instances.push_back(mirrored);
  const Scene read = copy_of(scene, folder.path("s.xml"), true);
  EXPECT_EQ(text_of(folder.path("s.xml")).find("flip_normals"), std::string::npos);
  ASSERT_EQ(read.instances.size(), 2u);
  const auto corners = [&](std::size_t i) {
    return std::get<TriangleMesh>(read.shape_of(read.instances[i])).triangles.at(0);
  };
  EXPECT_EQ(corners(0), glm::uvec3(0, 1, 2));
  EXPECT_EQ(corners(1), glm::uvec3(0, 2, 1));
  // In Mitsuba normals of triangles follow from the order of their vertices in the world.
  EXPECT_FALSE(read.instances[0].flip_normals);
  EXPECT_TRUE(read.instances[1].flip_normals);
}

/// A mesh file holds one set of texture coordinates: that which an instance shows its textures by.
TEST(SceneWriter, MeshesGetTheTextureCoordinatesThatAreUsed) {
  for (const bool mitsuba : {false, true}) {
    const TemporaryFolder folder;
    Scene scene;
    scene.bitmaps = {bitmap(BitmapFormat::u8, 3, ColorSpace::srgb)};
    for (std::uint32_t set = 0; set < 2; ++set)
      scene.textures.push_back({.source = BitmapTexture{.bitmap = 0}, .uv_set = set, .name = set == 0 ? "a" : "b"});
    TriangleMesh two = mesh();
    two.uv_sets.push_back({{0.5f, 0.25f}, {1.0f, 0.0f}, {0.0f, 1.0f}});
    scene.add(two, DiffuseBsdf{ColorParameter(glm::dvec3(1.0), 1)}).name = "cup";
    scene.materials.push_back({.bsdf = DiffuseBsdf{ColorParameter(glm::dvec3(1.0), 0)}});
    scene.materials.push_back({.bsdf = DiffuseBsdf{}});
    for (const std::uint32_t material : {1u, 2u}) {
      Instance other = scene.instances[0];
      other.material = material;
      scene.instances.push_back(other);
    }
    const Scene read = copy_of(scene, folder.path("s.xml"), mitsuba);
    ASSERT_EQ(read.instances.size(), 3u);
    const auto sets = [&](std::size_t i) { return std::get<TriangleMesh>(read.shape_of(read.instances[i])).uv_sets; };
    EXPECT_EQ(sets(0), std::vector(1, two.uv_sets[1]));
    EXPECT_EQ(sets(1), std::vector(1, two.uv_sets[0]));
    scene.add(two, DiffuseBsdf{ColorParameter(glm::dvec3(1.0), 1)}, AreaEmitter{ColorParameter(glm::dvec3(1.0), 0)})
        .name = "cup";
    try {
      copy_of(scene, folder.path("t.xml"), mitsuba);
      FAIL() << "two sets do not fit";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what())
                    .find("\"cup\" uses several sets of texture coordinates (set 0 for the texture "
                          "\"a\", set 1 for the texture \"b\")"),
                std::string::npos)
          << error.what();
    }
    EXPECT_FALSE(std::filesystem::exists(folder.path("t.xml")));
  }
}

}  // namespace
}  // namespace etendue::testing
