/// Textures as data: invariants, the scene's hash, what is true of a texture as a whole.

#include <cmath>
#include <cstring>

#include <gmock/gmock.h>

#include "core/errors.h"
#include "scene/invariants.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

using ::testing::HasSubstr;

std::shared_ptr<Bitmap> grey(std::uint32_t width, std::uint32_t height, std::vector<std::uint8_t> codes) {
  auto bitmap = std::make_shared<Bitmap>();
  bitmap->width = width;
  bitmap->height = height;
  bitmap->channels = 1;
  bitmap->format = BitmapFormat::u8;
  for (const std::uint8_t code : codes) bitmap->texels.push_back(static_cast<std::byte>(code));
  return bitmap;
}

std::shared_ptr<Bitmap> floats(std::vector<float> values) {
  auto bitmap = std::make_shared<Bitmap>();
  bitmap->width = static_cast<std::uint32_t>(values.size());
  bitmap->height = bitmap->channels = 1;
  bitmap->texels.resize(values.size() * sizeof(float));
  std::memcpy(bitmap->texels.data(), values.data(), bitmap->texels.size());
  return bitmap;
}

/// A triangle with texture coordinates and a texture as its albedo.
Scene textured(std::variant<BitmapTexture, CheckerboardTexture, AttributeTexture> source = CheckerboardTexture{}) {
  Scene scene;
  TriangleMesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .normals = {}, .triangles = {{0, 1, 2}}};
  mesh.uv_sets.push_back({{0, 0}, {1, 0}, {0, 1}});
  scene.textures.push_back({.source = source, .name = "bricks"});
  scene.add(mesh, DiffuseBsdf{ColorParameter(glm::dvec3(1.0), 0)}).name = "wall";
  return scene;
}

void expect_refused(const Scene& scene, const std::string& words) {
  try {
    require_invariants(scene);
    ADD_FAILURE() << "accepted; expected " << words;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

TEST(SceneTextures, SoundOnesAreAccepted) {
  require_invariants(textured());
  Scene scene = textured(BitmapTexture{.bitmap = 0});
  scene.bitmaps = {grey(2, 1, {0, 255})};
  require_invariants(scene);
}

TEST(SceneTextures, WhatIsWrongIsSaid) {
  Scene scene = textured();
  std::get<DiffuseBsdf>(scene.materials[0].bsdf).albedo.texture = 7;
  expect_refused(scene, "albedo refers to number 7 of the scene's textures, of which there are 1");
  expect_refused(textured(BitmapTexture{.bitmap = 3}),
                 "refers to number 3 of the scene's pictures, of which there are 0");
  scene = textured(BitmapTexture{.bitmap = 0});
  scene.bitmaps = {nullptr};
  expect_refused(scene, "null pointer");
  scene.bitmaps = {grey(2, 2, {1, 2, 3})};
  expect_refused(scene, "2 × 2 texels of 1 channels in 3 bytes");
  scene.bitmaps = {floats({1.0f, NAN})};
  expect_refused(scene, "\"bricks\" has texels that are not finite");
  scene = textured();
  scene.textures[0].uv_transform[0][0] = INFINITY;
  expect_refused(scene, "the transform of the texture \"bricks\" is not affine");
  CheckerboardTexture within_itself;
  within_itself.texture1 = 0;
  scene = textured(within_itself);
  expect_refused(scene, "which is not among those before it");
  scene = textured(CheckerboardTexture{glm::dvec3(NAN), glm::dvec3(0)});
  expect_refused(scene, "a colour of the checkerboard");
}

TEST(SceneTextures, AShapeMustHaveWhatIsRead) {
  Scene scene = textured();
  scene.textures[0].uv_set = 1;
  expect_refused(scene, "\"wall\" has no set 1 of texture coordinates, which its albedo needs");
  auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
  scene.textures[0].uv_set = 0;
  mesh.uv_sets[0][1].x = 1e10f;
  expect_refused(scene, "has texture coordinates 10000000000 0; up to 1000000000 are supported");
  mesh.uv_sets.clear();
  expect_refused(scene, "\"wall\" has no texture coordinates");
  expect_refused(textured(AttributeTexture{}), "no colours of vertices");
  expect_refused(textured(AttributeTexture{AttributeTexture::Source::face_color}), "no colours of faces");
}

TEST(SceneTextures, RadianceHasItsRange) {
  Scene scene = textured(BitmapTexture{.bitmap = 0});
  scene.emitters.push_back({ColorParameter(glm::dvec3(2.0), 0)});
  scene.instances[0].emitter = 0;
  scene.bitmaps = {floats({1.0f, -0.5f})};
  expect_refused(scene, "use 0 to");
  scene.bitmaps = {floats({1.0f, 6e19f})};
  expect_refused(scene, "use 0 to");
  scene.bitmaps = {floats({1.0f, 4.5f})};
  require_invariants(scene);
  EXPECT_EQ(film_exponent(scene), 4);  // 2 · 4.5 is below 16
}

TEST(SceneTextures, TheHashKnowsThem) {
  Scene scene = textured(BitmapTexture{.bitmap = 0});
  scene.bitmaps = {grey(2, 1, {0, 255})};
  const std::uint64_t hash = scene_hash(scene);
  const auto expect_other = [&](const auto& change) {
    Scene other = scene;
    change(other);
    EXPECT_NE(scene_hash(other), hash);
  };
  expect_other([](Scene& s) { s.bitmaps = {grey(2, 1, {0, 254})}; });
  expect_other([](Scene& s) { s.bitmaps = {grey(1, 2, {0, 255})}; });
  expect_other([](Scene& s) { std::get<BitmapTexture>(s.textures[0].source).wrap_v = TextureWrap::clamp; });
  expect_other([](Scene& s) { std::get<BitmapTexture>(s.textures[0].source).filter = TextureFilter::nearest; });
  expect_other([](Scene& s) { std::get<BitmapTexture>(s.textures[0].source).color_space = ColorSpace::linear; });
  expect_other([](Scene& s) { s.textures[0].uv_transform[2][1] = 0.5; });
  expect_other([](Scene& s) { s.textures[0].source = CheckerboardTexture{}; });
  expect_other([](Scene& s) { std::get<DiffuseBsdf>(s.materials[0].bsdf).albedo.texture.reset(); });
}

TEST(SceneTextures, MeansAreThoseOfLight) {
  Scene scene = textured(BitmapTexture{.bitmap = 0});
  scene.bitmaps = {grey(2, 2, {0, 255, 255, 188})};
  EXPECT_NEAR(texture_facts(scene, scene.textures[0]).mean.x, (0.0 + 1.0 + 1.0 + 188.0 / 255.0) / 4.0, 1e-7);
  std::get<BitmapTexture>(scene.textures[0].source).color_space = ColorSpace::srgb;
  const TextureFacts facts = texture_facts(scene, scene.textures[0]);
  EXPECT_NEAR(facts.mean.y, (0.0 + 1.0 + 1.0 + std::pow((188.0 / 255.0 + 0.055) / 1.055, 2.4)) / 4.0, 1e-7);
  EXPECT_EQ(facts.least, glm::dvec3(0.0));
  EXPECT_EQ(facts.largest, glm::dvec3(1.0));
}

TEST(SceneTextures, LampsAreAsBrightAsTheirColours) {
  Scene scene = textured(AttributeTexture{AttributeTexture::Source::face_color});
  auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
  mesh.triangles.push_back({2, 1, 0});
  mesh.face_colors = {{1, 0, 0}, {0, 0, 3}};
  scene.emitters.push_back({ColorParameter(glm::dvec3(2.0), 0)});
  scene.instances[0].emitter = 0;
  KnownTextureFacts facts(scene);
  const EmitterRadiance faces(facts, scene.instances[0]);
  EXPECT_FALSE(faces.uniform());
  EXPECT_EQ(faces.mean(0), glm::dvec3(2, 0, 0));
  EXPECT_EQ(faces.mean(1), glm::dvec3(0, 0, 6));
  EXPECT_EQ(faces.largest(), 6.0);
  scene.textures[0].source = AttributeTexture{AttributeTexture::Source::vertex_color};
  mesh.vertex_colors = {{3, 0, 0}, {0, 6, 0}, {0, 0, 9}};
  EXPECT_EQ(EmitterRadiance(facts, scene.instances[0]).mean(0), glm::dvec3(2, 4, 6));
  scene.textures[0].source = CheckerboardTexture{glm::dvec3(1.0), glm::dvec3(0.5)};
  EXPECT_EQ(EmitterRadiance(facts, scene.instances[0]).mean(), glm::dvec3(1.5));
}

}  // namespace
}  // namespace etendue
