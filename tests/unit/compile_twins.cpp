// Primitives that need no place in the tree, and heaps of those that do.

#include "compile/twins.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "compile/compiled_scene.h"
#include "compile/overlap.h"

namespace etendue {
namespace {

gpu::Primitive triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  gpu::Primitive p{};
  p.kind = gpu::kPrimitiveTriangle;
  p.p0 = a, p.p1 = b, p.p2 = c;
  return p;
}
gpu::Primitive sphere(const glm::vec3& center, float radius) {
  gpu::Primitive p{};
  p.kind = gpu::kPrimitiveSphere;
  p.p0 = center;
  p.p1.x = radius;
  return p;
}

TEST(CompileTwins, OnlyTheSameVerticesInTheSameOrder) {
  const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  std::vector<gpu::Primitive> primitives = {
      triangle(a, b, c),
      sphere(a, 1.0f),
      triangle(b, c, a),  // turned
      triangle(c, b, a),  // the other side
      triangle(a, b, c),  // 4: as 0
      sphere(a, 1.5f),
      sphere(a, 1.0f),  // 6: as 1
      triangle(a, b, glm::vec3(0, std::nextafter(1.0f, 2.0f), 0)),
      triangle(-a, b, c),  // 8: −0 is 0
      triangle(a, a, c),
      triangle(a, c, c),
      triangle(c, b, c),  // 9, 10, 11: never hit
  };
  for (std::uint32_t i = 0; i < primitives.size(); ++i) primitives[i].kind |= i << gpu::kPrimitiveOrderShift;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
  for (const Twin& twin : find_twins(primitives)) found.emplace_back(twin.primitive, twin.stands_for_it);
  const decltype(found) wanted = {{4, 0}, {6, 1}, {8, 0}, {9, 9}, {10, 10}, {11, 11}};
  EXPECT_EQ(found, wanted);
}

TriangleMesh heap(std::size_t count, double step) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double z = step * i;
    for (const glm::dvec3& p : {glm::dvec3(-1, -1, z), glm::dvec3(1, -1, z), glm::dvec3(0, 1, z)})
      mesh.positions.push_back(p);
    mesh.triangles.push_back(glm::uvec3(0, 1, 2) + 3 * i);
  }
  return mesh;
}

TEST(CompileTwins, TakeNoPlaceInTheTreeAndStayLights) {
  Scene scene;
  scene.add(heap(50000, 0.0), DiffuseBsdf{}, AreaEmitter{glm::dvec3(1.0)});
  scene.add(heap(100, 0.01));
  const CompiledScene compiled = compile_scene(scene);
  EXPECT_LT(compiled.records.size(), 3u * 400) << "texels: 101 triangles and their nodes";
  ASSERT_EQ(compiled.light_primitives.size(), 50000u);
  for (std::uint32_t i = 0; i < 50000; ++i) {
    ASSERT_EQ(compiled.light_primitives[i].primitive.primitive, i);
    ASSERT_GT(compiled.light_primitives[i].prob, 0.0f);
  }
}

TEST(CompileCrowding, CountsWhatATreeCannotPart) {
  Scene scene;
  for (const TriangleMesh& mesh : {heap(3000, 0.0), heap(2000, 0.001), heap(500, 1e-9)}) scene.add(mesh);
  const Crowding crowding(scene);
  EXPECT_LE(crowding.primitives(), 2500u);
  EXPECT_GT(crowding.primitives(), 2000u);
  const std::size_t through = crowding.count_along({0.0, 0.0, 10.0}, {0.0, 0.0, -2.0}, INFINITY);
  EXPECT_EQ(through, crowding.primitives()) << "a ray along the heap meets them all";
  const std::size_t half = crowding.count_along({0.0, 0.0, 10.0}, {0.0, 0.0, -2.0}, 4.5);
  EXPECT_NEAR(static_cast<double>(half), 1000.0, 20.0) << "up to z = 1";
  EXPECT_EQ(crowding.count_along({5.0, 0.0, 10.0}, {0.0, 0.0, -2.0}, INFINITY), 0u) << "beside it";
}

TEST(CompileCrowding, FindsTheMiddleOfAFan) {
  TriangleMesh fan;
  constexpr std::uint32_t kCount = 6000;
  const glm::dvec3 at(20.0, -3.0, 7.0);
  fan.positions.push_back(at);
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double phi = 2.0 * std::numbers::pi * i / kCount;
    fan.positions.push_back(at + glm::dvec3(std::cos(phi), std::sin(phi), 0.1 * std::sin(40.0 * phi)));
    fan.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % kCount);
  }
  Scene scene;
  scene.add(fan);
  const auto place = Crowding(scene).find_place();
  ASSERT_TRUE(place.has_value());
  EXPECT_GT(place->count, kCount / 20);
  EXPECT_LT(glm::length(place->at - at), 1.0);
  EXPECT_FALSE(Crowding(Scene{}).find_place().has_value());
}

}  // namespace
}  // namespace etendue
