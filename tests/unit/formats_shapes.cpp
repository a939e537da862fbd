// Shapes of scene files: meshes that need no file, and exact ones.

#include <fmt/format.h>

#include "formats/mesh/builtin_meshes.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

TEST(Shapes, CubeAndRectangleFaceOutward) {
  const TriangleMesh cube = make_cube(), rectangle = make_rectangle();
  EXPECT_EQ(cube.triangles.size(), 12u);
  EXPECT_EQ(rectangle.triangles.size(), 2u);
  double area = 0.0;
  for (const TriangleMesh* mesh : {&cube, &rectangle}) {
    ASSERT_EQ(mesh->uv_sets.size(), 1u);
    ASSERT_EQ(mesh->uv_sets[0].size(), mesh->positions.size());
    for (const glm::uvec3& t : mesh->triangles) {
      const auto& p = mesh->positions;
      const glm::dvec3 n = glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
      const glm::dvec3 outward = mesh == &cube ? (p[t.x] + p[t.y] + p[t.z]) / 3.0 : glm::dvec3(0, 0, 1);
      EXPECT_GT(glm::dot(n, outward), 0.0);
      area += 0.5 * glm::length(n);
      // Upward v where u × v is the normal: on the rectangle, not on the cube.
      const auto& uv = mesh->uv_sets[0];
      const glm::vec2 a = uv[t.y] - uv[t.x], b = uv[t.z] - uv[t.x];
      EXPECT_EQ(a.x * b.y - a.y * b.x, mesh == &cube ? -1.0f : 1.0f);
    }
  }
  EXPECT_EQ(area, 24.0 + 4.0);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(glm::dvec2(rectangle.uv_sets[0][i]), 0.5 * (glm::dvec2(rectangle.positions[i]) + 1.0));
}

TEST(Shapes, AreRead) {
  const Parsed parsed = parse(
      scene_around("<shape type='rectangle'><transform name='toWorld'><scale value='2,2,2'/></transform></shape>"
                   "<mesh type='cube'><boolean name='flipNormals' value='true'/></mesh><mesh type='disk'/>"
                   "<mesh type='cylinder'><point name='p0' value='1 0 0'/><float name='radius' value='0.5'/></mesh>"
                   "<mesh type='sphere'><transform name='toWorld'><scale value='3 3 3'/></transform></mesh>"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  EXPECT_EQ(all_messages(parsed.diagnostics), "");
  const Scene& scene = parsed.scene();
  EXPECT_EQ(scene.instances.at(0).name, "rectangle");
  EXPECT_EQ(scene.instances[0].world_from_object[0][0], 2.0);
  EXPECT_TRUE(scene.instances[1].flip_normals);
  EXPECT_TRUE(std::holds_alternative<Disk>(scene.shapes[2]));
  const auto& cylinder = std::get<Cylinder>(scene.shapes[3]);
  EXPECT_EQ(cylinder.p0, glm::dvec3(1, 0, 0));
  EXPECT_EQ(cylinder.p1, glm::dvec3(0, 0, 1));
  EXPECT_EQ(cylinder.radius, 0.5);
  EXPECT_EQ(scene.instances[4].world_from_object[2][2], 3.0);
}

TEST(Shapes, WhatTheirTransformsCannotDo) {
  for (const char* type : {"sphere", "cylinder"}) {
    const Parsed parsed = parse(scene_around(
        fmt::format("<mesh type='{}'>\n<transform name='toWorld'><scale value='1 2 1'/></transform></mesh>", type)));
    EXPECT_FALSE(parsed.file);
    EXPECT_NE(all_messages(parsed.diagnostics).find(fmt::format("s.xml:3:1: the transform of the {}", type)),
              std::string::npos)
        << all_messages(parsed.diagnostics);
  }
  const Parsed flat = parse(scene_around("<mesh type='cylinder'>\n<point name='p1' value='0 0 0'/></mesh>"));
  EXPECT_NE(all_messages(flat.diagnostics).find("s.xml:3:25: the cylinder \"cylinder\" has no height"),
            std::string::npos)
      << all_messages(flat.diagnostics);
}

}  // namespace
}  // namespace etendue::testing
