/// Lamps of varying brightness: how they are divided, and how bright the parts are.

#include <functional>
#include <memory>

#include <gtest/gtest.h>

#include "scene/lamp_parts.h"
#include "scene/placed.h"

namespace etendue {
namespace {

/// A unit square of two triangles whose radiance is 2 times a texture.
struct Lamp {
  Lamp() {
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.uv_sets.push_back({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  }
  Scene with(Texture texture, std::size_t lamps = 1) const {
    Scene scene;
    scene.textures.push_back(std::move(texture));
    if (bitmap) scene.bitmaps.push_back(bitmap);
    for (std::size_t i = 0; i < lamps; ++i)
      scene.add(mesh, DiffuseBsdf{}, AreaEmitter{ColorParameter(glm::dvec3(2.0), 0)});
    return scene;
  }
  Scene pictured(std::uint32_t side, const std::function<std::uint8_t(std::uint32_t, std::uint32_t)>& code) {
    bitmap = std::make_shared<Bitmap>();
    bitmap->width = bitmap->height = side;
    bitmap->channels = 1;
    bitmap->format = BitmapFormat::u8;
    bitmap->color_space = ColorSpace::linear;
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x) bitmap->texels.push_back(static_cast<std::byte>(code(x, y)));
    }
    return with({.source = BitmapTexture{.bitmap = 0, .filter = TextureFilter::nearest}});
  }
  TriangleMesh mesh;
  std::shared_ptr<Bitmap> bitmap;
};

/// Brightness times area.
double power(const Scene& scene, const LampParts& parts) {
  const auto& mesh = std::get<TriangleMesh>(scene.shapes[0]);
  double sum = 0.0;
  for (std::size_t i = 0; i < parts.cells.size(); ++i) {
    const double area = triangle_area(mesh, mesh.triangles[i]) / (parts.cells[i] * parts.cells[i]);
    for (std::uint32_t p = parts.first[i]; p < parts.first[i + 1]; ++p) sum += area * parts.brightness[p];
  }
  return sum;
}

constexpr double kEven = 0.05;  // share of the mean that is added to every part

TEST(SceneLampParts, AnEvenPictureIsNotDivided) {
  EXPECT_TRUE(lamp_parts(Lamp().pictured(16, [](auto, auto) { return 200; })).empty());
  EXPECT_TRUE(lamp_parts(Lamp().pictured(16, [](auto x, auto y) { return 190 + (x + y) % 2 * 20; })).empty());
}

TEST(SceneLampParts, OnlyTexturedMeshesAreDivided) {
  Scene scene;
  scene.add(Sphere{}, DiffuseBsdf{}, AreaEmitter{ColorParameter(1.0, 1.0, 1.0)});
  scene.add(Lamp().mesh, DiffuseBsdf{}, AreaEmitter{ColorParameter(1.0, 1.0, 1.0)});
  scene.add(Lamp().mesh, DiffuseBsdf{});
  EXPECT_TRUE(lamp_parts(scene).empty());
}

// A picture whose left half is black.
TEST(SceneLampParts, PartsAreAsBrightAsThePicture) {
  const Scene scene = Lamp().pictured(8, [](auto x, auto) { return x < 4 ? 0 : 255; });
  const LampParts parts = lamp_parts(scene).at(0);
  ASSERT_EQ(parts.cells, (std::vector<std::uint32_t>{8, 8}));
  ASSERT_EQ(parts.first, (std::vector<std::uint32_t>{0, 64, 128}));
  const double mean = 1.0;  // half of 2
  EXPECT_NEAR(power(scene, parts), (1.0 + kEven) * mean, 0.02);
  // u counts from the first corner (0, 0): the cells there are black, but not left out.
  EXPECT_NEAR(parts.brightness[0], kEven * mean, 1e-12);
  // The last cells along the edge from (1, 0) to (1, 1), near the former.
  EXPECT_NEAR(parts.brightness[63], (2.0 + kEven * mean), 1e-12);
}

// A mirror exchanges the last two corners of each triangle, and thereby its cells along v.
TEST(SceneLampParts, AMirroredLampHasMirroredParts) {
  Scene scene = Lamp().pictured(8, [](auto x, auto y) { return x > 5 && y > 5 ? 255 : 3; });
  const LampParts plain = lamp_parts(scene).at(0);
  scene.instances[0].world_from_object[0][0] = -1.0;
  const LampParts mirrored = lamp_parts(scene).at(0);
  for (std::uint32_t i = 0; i < 8; ++i) {
    for (std::uint32_t j = 0; j < 8; ++j)
      EXPECT_NEAR(mirrored.brightness[8 * i + j], plain.brightness[8 * i + 7 - j], 1e-9) << i << " " << j;
  }
}

TEST(SceneLampParts, ACheckerboardIsDividedByItsSquares) {
  const Scene scene =
      Lamp().with({.source = CheckerboardTexture{.color0 = glm::dvec3(1.0), .color1 = glm::dvec3(0.0)}});
  const LampParts parts = lamp_parts(scene).at(0);
  EXPECT_EQ(parts.cells, (std::vector<std::uint32_t>{2, 2}));
  EXPECT_NEAR(power(scene, parts), (1.0 + kEven) * 1.0, 0.1);
}

TEST(SceneLampParts, ColoursOfVerticesAndFacesCount) {
  Lamp lamp;
  lamp.mesh.vertex_colors = {{0, 0, 0}, {1, 1, 1}, {1, 1, 1}, {0, 0, 0}};
  lamp.mesh.face_colors = {{1, 1, 1}, {0.1, 0.1, 0.1}};
  const Scene vertices = lamp.with({.source = AttributeTexture{AttributeTexture::Source::vertex_color}});
  EXPECT_NEAR(power(vertices, lamp_parts(vertices).at(0)), (1.0 + kEven) * 1.0, 1e-2);
  const Scene faces = lamp.with({.source = AttributeTexture{AttributeTexture::Source::face_color}});
  const LampParts parts = lamp_parts(faces).at(0);
  EXPECT_EQ(parts.cells, (std::vector<std::uint32_t>{1, 1}));
  EXPECT_NEAR(parts.brightness[0] / parts.brightness[1], 10.0, 1e-6);
}

// Tables stay small however many lamps show a large picture.
TEST(SceneLampParts, ThereAreNoMorePartsThanTheLimit) {
  Lamp lamp;
  lamp.pictured(512, [](auto x, auto y) { return (x * 7 + y * 13) % 97 == 0 ? 255 : 0; });
  constexpr std::size_t kLamps = 600;
  const auto all = lamp_parts(lamp.with({.source = BitmapTexture{.bitmap = 0}}, kLamps));
  std::size_t sum = 0;
  for (const auto& [instance, parts] : all) sum += parts.brightness.size();
  EXPECT_GT(sum, 2 * kLamps);
  EXPECT_LE(sum, std::size_t{1} << 18);
}

}  // namespace
}  // namespace etendue
