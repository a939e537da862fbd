/// Lists of vectors that are kept in single precision where that changes nothing.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "scene/scene.h"

namespace etendue {
namespace {

using Vectors = std::vector<glm::dvec3>;

TEST(VectorList, IsNarrowedOnlyWhereNothingChanges) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Vectors exact = {{0.5, -0.0, 0x1p-149}, {3.4028234663852886e38, 1e9, -7.25}};
  VectorList list = exact;
  list.narrow();
  EXPECT_EQ(list.bytes(), 2 * sizeof(glm::vec3));
  EXPECT_EQ(list, exact);
  EXPECT_TRUE(std::signbit(list[0].y));
  for (const double value : {0.1, 0x1p-150, 1.0 + 0x1p-24, 3.5e38, 1e300, kInfinity, std::nan("")}) {
    Vectors with = exact;
    with.emplace_back(0.0, 1.0, value);
    list = with;
    list.narrow();
    EXPECT_EQ(list.bytes(), 3 * sizeof(glm::dvec3)) << value;
    EXPECT_TRUE(list[2].z == value || std::isnan(value)) << value;
  }
}

TEST(VectorList, CanBeChangedAgain) {
  VectorList list = {{1, 2, 3}, {4, 5, 6}};
  list.narrow();
  list.narrow();
  list.push_back({0.1, 0, 0});
  list.edit()[0].y = 0.2;
  EXPECT_EQ(list, (Vectors{{1, 0.2, 3}, {4, 5, 6}, {0.1, 0, 0}}));
  EXPECT_EQ(Vectors(list.begin(), list.end()).size(), 3u);
  EXPECT_NE(list, (Vectors{{1, 0.2, 3}, {4, 5, 6}}));
  list.clear();
  EXPECT_TRUE(list.empty());
  list.narrow();
  EXPECT_EQ(list.size(), 0u);
}

TEST(VectorList, AScenesHashIsThatOfItsNumbers) {
  TriangleMesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.25}}, .normals = {}, .triangles = {{0, 1, 2}}};
  mesh.normals = Vectors(3, {0, 0, 1});
  Scene wide, narrow;
  wide.add(mesh);
  mesh.positions.narrow();
  mesh.normals.narrow();
  narrow.add(mesh);
  EXPECT_EQ(scene_hash(wide), scene_hash(narrow));
}

}  // namespace
}  // namespace etendue
