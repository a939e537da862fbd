/// What the reference takes a texture for, at places where the answer is known by hand.

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "reference/texture.h"

namespace etendue::reference {
namespace {

/// A scene of one large triangle whose texture coordinates are its x and y, from −16 to 16 and beyond.
struct Plane {
  Scene scene;

  explicit Plane(const BitmapTexture& source, std::uint32_t width, std::uint32_t height, std::vector<float> grey) {
    auto bitmap = std::make_shared<Bitmap>();
    bitmap->width = width;
    bitmap->height = height;
    bitmap->channels = 1;
    bitmap->texels.resize(grey.size() * sizeof(float));
    std::memcpy(bitmap->texels.data(), grey.data(), bitmap->texels.size());
    scene.bitmaps.push_back(std::move(bitmap));
    add(source);
  }
  explicit Plane(const CheckerboardTexture& source) { add(source); }

  double at(double u, double v) const {
    // (−16,−16) + 64 (a, b)
    const double a = (u + 16.0) / 64.0, b = (v + 16.0) / 64.0;
    const Surface surface{.ng = {0, 0, 1}, .ns = {0, 0, 1}, .weights = {1.0 - a - b, a, b}};
    return texture_value(scene, scene.textures[0], surface).x;
  }

 private:
  template <typename Source>
  void add(const Source& source) {
    TriangleMesh mesh{
        .positions = {{-16, -16, 0}, {48, -16, 0}, {-16, 48, 0}}, .normals = {}, .triangles = {{0, 1, 2}}};
    mesh.uv_sets.push_back({{-16, -16}, {48, -16}, {-16, 48}});
    scene.textures.push_back({.source = source});
    scene.add(mesh, DiffuseBsdf{ColorParameter(Vec3(1.0), 0)});
  }
};

BitmapTexture wrapped(TextureWrap wrap, TextureFilter filter) {
  return {.bitmap = 0, .wrap_u = wrap, .wrap_v = wrap, .filter = filter, .color_space = {}};
}

TEST(ReferenceTextures, RowsGoDownFromOneAndTexelsHaveTheirCentresInTheMiddle) {
  // 1 2 3
  // 4 5 6
  for (const auto filter : {TextureFilter::nearest, TextureFilter::bilinear}) {
    const Plane plane(wrapped(TextureWrap::repeat, filter), 3, 2, {1, 2, 3, 4, 5, 6});
    EXPECT_NEAR(plane.at(1.0 / 6.0, 0.75), 1.0, 1e-12);
    EXPECT_NEAR(plane.at(5.0 / 6.0, 0.75), 3.0, 1e-12);
    EXPECT_NEAR(plane.at(1.0 / 6.0, 0.25), 4.0, 1e-12);
  }
  const Plane linear(wrapped(TextureWrap::repeat, TextureFilter::bilinear), 3, 2, {1, 2, 3, 4, 5, 6});
  EXPECT_NEAR(linear.at(1.0 / 3.0, 0.75), 1.5, 1e-12);
  EXPECT_NEAR(linear.at(0.5, 0.5), 3.5, 1e-12);
  EXPECT_NEAR(linear.at(0.0, 0.75), 2.0, 1e-12);  // between the last and the first
}

TEST(ReferenceTextures, WrapsAsItsWordSays) {
  const auto row = [](TextureWrap wrap) {
    const Plane plane(wrapped(wrap, TextureFilter::nearest), 3, 1, {1, 2, 3});
    std::string text;
    for (int i = -7; i <= 7; ++i) text += std::to_string(std::lround(plane.at((i + 0.5) / 3.0, 0.5)));
    return text;
  };
  EXPECT_EQ(row(TextureWrap::repeat), "312312312312312");
  EXPECT_EQ(row(TextureWrap::clamp), "111111112333333");
  EXPECT_EQ(row(TextureWrap::mirror), "112332112332112");
}

TEST(ReferenceTextures, ACheckerboardsSquaresAreHalfAUnit) {
  const Plane plane(CheckerboardTexture{Vec3(1.0), Vec3(0.0)});
  EXPECT_EQ(plane.at(0.25, 0.25), 1.0);
  EXPECT_EQ(plane.at(0.75, 0.25), 0.0);
  EXPECT_EQ(plane.at(0.75, 0.75), 1.0);
  EXPECT_EQ(plane.at(-0.25, 0.25), 0.0);
  EXPECT_EQ(plane.at(-0.25, -0.25), 1.0);
  EXPECT_EQ(plane.at(-3.25, 5.75), 1.0);
}

TEST(ReferenceTextures, ACheckerboardShowsTexturesWhereTheyLieOnTheSurface) {
  CheckerboardTexture board{Vec3(0.5), Vec3(2.0)};
  board.texture1 = 1;
  Plane plane(board);
  plane.scene.textures[0].uv_transform = glm::dmat3(2.0, 0, 0, 0, 2.0, 0, 0, 0, 1);  // squares of side 1/4
  plane.scene.textures.push_back({.source = CheckerboardTexture{Vec3(10.0), Vec3(20.0)}});
  EXPECT_EQ(plane.at(0.125, 0.125), 0.5);
  EXPECT_EQ(plane.at(0.375, 0.125), 20.0);  // in the inner one's first square, of side 1/2
  EXPECT_EQ(plane.at(0.625, 0.375), 40.0);  // in its second
}

TEST(ReferenceTextures, ASphereTurnsAroundItsOwnZ) {
  Plane plane(wrapped(TextureWrap::clamp, TextureFilter::bilinear), 2, 2, {0, 4, 0, 4});
  plane.scene.shapes[0] = Sphere{};
  // u from 0 to 1 becomes 0 at the centre of the first texel, 4 at that of the second.
  const auto at = [&](const Vec3& n) { return texture_value(plane.scene, plane.scene.textures[0], {.ns = n}).x; };
  EXPECT_NEAR(at({0, 1, 0}), 0.0, 1e-12);   // u = 1/4
  EXPECT_NEAR(at({-1, 0, 0}), 2.0, 1e-12);  // u = 1/2
  EXPECT_NEAR(at({0, -1, 0}), 4.0, 1e-12);  // u = 3/4
  // Turned by a quarter around z, the point at y is that which was at x.
  plane.scene.instances[0].world_from_object = glm::dmat4({0, 1, 0, 0}, {-1, 0, 0, 0}, {0, 0, 1, 0}, {5, 6, 7, 1});
  EXPECT_NEAR(at({0, -1, 0}), 2.0, 1e-12);
}

TEST(ReferenceTextures, ASpheresNorthIsThePicturesTop) {
  Plane plane(wrapped(TextureWrap::clamp, TextureFilter::nearest), 1, 2, {7, 9});
  plane.scene.shapes[0] = Sphere{};
  const auto at = [&](const Vec3& n) { return texture_value(plane.scene, plane.scene.textures[0], {.ns = n}).x; };
  EXPECT_EQ(at(glm::normalize(Vec3(1, 1, 2))), 7.0);
  EXPECT_EQ(at(glm::normalize(Vec3(1, 1, -2))), 9.0);
}

TEST(ReferenceTextures, ADiskHasPolarCoordinates) {
  Plane plane(wrapped(TextureWrap::clamp, TextureFilter::bilinear), 2, 2, {0, 4, 1, 5});
  plane.scene.shapes[0] = Disk{};
  const auto at = [&](const Vec3& p) { return texture_value(plane.scene, plane.scene.textures[0], {.p = p}).x; };
  // u, the distance, from 1/4 to 3/4 adds 4; the angle from a quarter to three quarters of a turn adds 1.
  EXPECT_NEAR(at({0, 0.25, 0}), 0.0, 1e-12);
  EXPECT_NEAR(at({0, 0.5, 0}), 2.0, 1e-12);
  EXPECT_NEAR(at({0, -0.75, 0}), 5.0, 1e-12);
  EXPECT_NEAR(at({-0.75, 0, 0}), 4.5, 1e-12);
  // Wider along x and mirrored along y: of its own space.
  plane.scene.instances[0].world_from_object = glm::dmat4({3, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, 1, 0}, {5, 6, 7, 1});
  EXPECT_NEAR(at({5 - 2.25, 6, 7}), 4.5, 1e-12);
  EXPECT_NEAR(at({5, 6.75, 7}), 5.0, 1e-12);
}

TEST(ReferenceTextures, APictureHangsDownACylinderFromItsFirstEnd) {
  Plane plane(wrapped(TextureWrap::clamp, TextureFilter::bilinear), 2, 2, {0, 4, 1, 5});
  plane.scene.shapes[0] = Cylinder{{0, 0, 1}, {0, 0, 3}, 1.0};
  const auto at = [&](const Vec3& p) { return texture_value(plane.scene, plane.scene.textures[0], {.p = p}).x; };
  EXPECT_NEAR(at({0, 1, 1.5}), 0.0, 1e-12);
  EXPECT_NEAR(at({0, 1, 2.5}), 1.0, 1e-12);
  EXPECT_NEAR(at({0, -1, 1.5}), 4.0, 1e-12);
  EXPECT_NEAR(at({-1, 0, 2.0}), 2.5, 1e-12);
  // Along y the turn begins at x and goes on toward −z: that is where [Duff2017] puts them.
  plane.scene.shapes[0] = Cylinder{{0, 0, 0}, {0, 2, 0}, 1.0};
  EXPECT_NEAR(at({0, 0.5, -1}), 0.0, 1e-12);
  EXPECT_NEAR(at({0, 0.5, 1}), 4.0, 1e-12);
}

TEST(ReferenceTextures, ParametersAreFactors) {
  Plane plane(wrapped(TextureWrap::repeat, TextureFilter::nearest), 1, 1, {0.5f});
  const Surface surface{.weights = {1, 0, 0}};
  EXPECT_EQ(at_point(plane.scene, ColorParameter(Vec3(2, 4, 6), 0), surface), Vec3(1, 2, 3));
  EXPECT_EQ(at_point(plane.scene, ScalarParameter(3.0, 0, TextureChannel::green), surface), 1.5);
  EXPECT_EQ(at_point(plane.scene, ScalarParameter(3.0, 0, TextureChannel::alpha), surface), 3.0);
  EXPECT_NEAR(at_point(plane.scene, ScalarParameter(3.0, 0, TextureChannel::luminance), surface), 1.5, 1e-6);
  const Bsdf constant = at_point(plane.scene, plane.scene.materials[0].bsdf, surface);
  EXPECT_EQ(std::get<DiffuseBsdf>(constant).albedo.value, Vec3(0.5));
  EXPECT_FALSE(std::get<DiffuseBsdf>(constant).albedo.texture);
}

}  // namespace
}  // namespace etendue::reference
