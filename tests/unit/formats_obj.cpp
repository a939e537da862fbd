// OBJ files: what is understood, what is refused and where, polygons, and what becomes of normals.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "formats/mesh/polygon.h"
#include "formats_testing.h"
#include "scene/placed.h"

namespace etendue::testing {
namespace {

TriangleMesh read(std::string_view text, std::size_t chunk = std::string_view::npos) {
  Diagnostics diagnostics;
  std::optional<TriangleMesh> mesh = read_obj(memory_source(text, chunk), "m.obj", {}, diagnostics);
  EXPECT_TRUE(mesh.has_value()) << all_messages(diagnostics);
  return mesh.value_or(TriangleMesh{});
}

const std::string kThree = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(Obj, AllForms) {
  const TriangleMesh mesh = read("# comment\nmtllib a.mtl\no thing\ng group\ns off\nusemtl stone\n" + kThree +
                                 "vt 0 0\nvt 1\nvt 0 1 0\nvn 0 0 1\nvn 0 0 2\n\n  \t\n"
                                 "f 1 2 3\nf 1/1 2/2 3/3\nf 1//1 2//1 3//1\nf 1/1/1 2/2/1 3/3/1\nf -3 -2 -1\nf "
                                 "-3/-3/-2 -2/-2/-2 -1/-1/-2 # end\nf\t1  2 \t3  \n");
  EXPECT_EQ(mesh.triangles.size(), 7u);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) {
    EXPECT_EQ(mesh.positions[t.x], glm::dvec3(0, 0, 0));
    EXPECT_EQ(mesh.positions[t.y], glm::dvec3(1, 0, 0));
    EXPECT_EQ(mesh.positions[t.z], glm::dvec3(0, 1, 0));
    for (int i = 0; i < 3; ++i)
      EXPECT_EQ(mesh.normals[t[i]], glm::dvec3(0, 0, 1)) << "given, or the plane's where none is";
  }
}

TEST(Obj, NoNormalsStayNoNormalsAndVerticesAreShared) {
  const TriangleMesh mesh = read(kThree + "v 1 1 0\nv 7 7 7\nf 1 2 3\nf 2 4 3\n");
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_EQ(mesh.positions.size(), 4u) << "the vertex no face uses is left out";
  EXPECT_EQ(mesh.triangles[0], glm::uvec3(0, 1, 2));
  EXPECT_EQ(mesh.triangles[1], glm::uvec3(1, 3, 2));
}

TEST(Obj, VerticesWithSeveralNormalsAreSplit) {
  const TriangleMesh mesh = read(kThree +
                                 "vn 0 0 1\nvn 1 0 0\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 2//2 3//2\nf 1//3 2//3 "
                                 "3//3\nf 3//2 2//2 1//2\nf 1//1 2//2 3//3\n");
  EXPECT_EQ(mesh.positions.size(), 9u);
  EXPECT_EQ(mesh.triangles[3], glm::uvec3(mesh.triangles[1].z, mesh.triangles[1].y, mesh.triangles[1].x));
  EXPECT_EQ(mesh.normals[mesh.triangles[4].x], glm::dvec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[mesh.triangles[4].y], glm::dvec3(1, 0, 0));
  EXPECT_EQ(mesh.normals[mesh.triangles[4].z], glm::dvec3(0, 1, 0));
}

TEST(Obj, ManyNormalsOfOnePositionKeepTheirCorners) {
  // Each corner has a normal of its own, all at three positions: the table of further vertices grows many times.
  std::string text = kThree;
  constexpr int kFaces = 3000;
  for (int i = 0; i < 3 * kFaces; ++i) text += fmt::format("vn 1 {} {}\n", i % 97, i);
  for (int i = 0; i < kFaces; ++i) text += fmt::format("f 1//{} 2//{} 3//{}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
  for (int i = 0; i < kFaces; ++i) text += fmt::format("f 1//{} 2//{} 3//{}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
  const TriangleMesh mesh = read(text);
  ASSERT_EQ(mesh.positions.size(), 3u * kFaces);
  for (int i = 0; i < kFaces; ++i) {
    EXPECT_EQ(mesh.triangles[kFaces + i], mesh.triangles[i]);
    for (int corner = 0; corner < 3; ++corner) {
      const int n = 3 * i + corner;
      const glm::dvec3 wanted = glm::normalize(glm::dvec3(1, n % 97, n));
      EXPECT_LT(glm::length(mesh.normals[mesh.triangles[i][corner]] - wanted), 1e-12);
      EXPECT_EQ(mesh.positions[mesh.triangles[i][corner]], glm::dvec3(corner == 1, corner == 2, 0));
    }
  }
}

TEST(Obj, AllBadLinesAreListed) {
  Diagnostics diagnostics;
  const std::string text =
      "v 0 0 0\nv 1 x 0\nv 0 1 0\nvn nan 0 1\nf 1 2 3\nf 1 2 4\nf 1 2\nf 1//1 2//1 3//1\nf 1//1 1//1 3//1\n";
  EXPECT_FALSE(read_obj(memory_source(text), "m.obj", {}, diagnostics));
  EXPECT_EQ(all_messages(diagnostics),
            "m.obj:2:5: \"x\" is not a number; write it like 1.5 or -2e3\n"
            "m.obj:6:7: index 4 of a vertex is out of range; the file has 3 so far\n"
            "m.obj:7:1: a face has 2 corners; it needs 3 or more\n"
            "m.obj:4:4: \"nan\" is not a finite number; write it like 1.5 or -2e3\n");
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "f x\n";
  Diagnostics few;
  EXPECT_FALSE(read_obj(memory_source(many), "m.obj", {}, few));
  EXPECT_EQ(few.error_count(), 20u);
}

/// The mesh of a text that is to be read with these warnings and no error.
TriangleMesh read_with_warnings(const std::string& text, const std::string& warnings) {
  Diagnostics diagnostics;
  const auto mesh = read_obj(memory_source(text), "m.obj", {}, diagnostics);
  EXPECT_EQ(all_messages(diagnostics), warnings);
  EXPECT_FALSE(diagnostics.has_errors());
  return mesh.value_or(TriangleMesh{});
}

TEST(Obj, BadElementsThatNoFaceUsesAreLeftOut) {
  const std::string good = kThree + "vn 0 0 1\n";
  const TriangleMesh wanted = read(good + "f 1//1 2//1 3//1\n");
  const std::string says = "is not a finite number; write it like 1.5 or -2e3; no face uses this ";
  for (const std::string nan : {"nan", "-inf"}) {
    const TriangleMesh normal = read_with_warnings(good + "vn " + nan + " 0 1\nf 1//1 2//1 3//1\n",
                                                   "m.obj:5:4: \"" + nan + "\" " + says + "normal: left out\n");
    EXPECT_EQ(normal.normals, wanted.normals);
  }
  const TriangleMesh three =
      read_with_warnings(good + "vn nan nan nan\nvn 1 0\nvn 1e999 0 0\nf 1//1 2//1 3//1\n",
                         "m.obj:5:4: \"nan\" " + says + "normal, nor 2 more like it: left out\n");
  EXPECT_EQ(three.normals, wanted.normals);
  const TriangleMesh vertex =
      read_with_warnings(good + "v nan 0 0\nf 1//1 2//1 3//1\n", "m.obj:5:3: \"nan\" " + says + "vertex: left out\n");
  EXPECT_EQ(vertex.positions, wanted.positions);
}

TEST(Obj, BadElementsAfterTheFirstFewAreErrorsToo) {
  std::string text = kThree;
  for (int i = 0; i < 100; ++i) text += "v nan 0 0\n";
  Diagnostics diagnostics;
  EXPECT_FALSE(read_obj(memory_source(text + "f 1 2 90\nf 1 2 91\n"), "m.obj", {}, diagnostics));
  EXPECT_EQ(all_messages(diagnostics), "m.obj:104:1: vertex 90 of this face could not be read\n");
}

TEST(Obj, TextureCoordinatesNeverRefuseAMesh) {
  const std::string ignored = "; texture coordinates are ignored, here and below\n";
  const std::string face = "f 1/1 2/2 3/1\n";
  const VectorList wanted = read(kThree + "f 1 2 3\n").positions;
  const auto expect = [&](const std::string& text, const std::string& warnings) {
    EXPECT_EQ(read_with_warnings(kThree + text, warnings).positions, wanted);
  };
  expect("vt nan nan\nvt x\n" + face, "m.obj:4:4: \"nan\" is not a finite number; write it like 1.5 or -2e3" + ignored);
  expect("vt 1 2 3 4\nvt 0\n" + face, "m.obj:4:10: a texture coordinate has more than 3 numbers" + ignored);
  expect(face, "m.obj:4:5: index 1 of a texture coordinate is out of range; the file has 0 so far" + ignored);
  expect("vt 0 0\nf 1/1 2/0 3/-1\n", "m.obj:5:9: index 0 of a texture coordinate; indices count from 1" + ignored);
}

TEST(Obj, CornersWithEmptyFields) {
  const std::string given = kThree + "vt 0 0\nvn 0 0 1\n";
  for (const std::string face : {"f 1/ 2/ 3/\n", "f 1// 2// 3//\n", "f 1/1/ 2/1/ 3/1/\n", "f 1/ 2// 3/1/\n"}) {
    const TriangleMesh mesh = read(given + face);
    EXPECT_EQ(mesh.triangles, std::vector<glm::uvec3>{glm::uvec3(0, 1, 2)}) << face;
    EXPECT_TRUE(mesh.normals.empty()) << face;
  }
}

TEST(Obj, FacesWithoutNormalsAmongOthersGetTheirPlane) {
  const TriangleMesh mesh = read(kThree + "v 0 0 1\nvn 0 0 1\nvn 0 0 0\nf 1 2 4\nf 1//1 2//1 3//1\nf 1//2 2//2 4//2\n");
  for (const std::size_t flat : {0u, 2u}) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(mesh.normals[mesh.triangles[flat][i]], glm::dvec3(0, -1, 0));
  }
}

TEST(Obj, LineEndsContinuationsAndMarks) {
  const TriangleMesh unix_lines = read(kThree + "f 1 2 3\n");
  for (const std::string& text :
       {std::string("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n"), std::string("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3"),
        std::string("\xef\xbb\xbfv 0 0 0\nv 1 \\\n 0 0\nv 0 1 0\nf 1 \\\r\n2\\\n3"), kThree + "f 1 2 3 \\"}) {
    for (const std::size_t chunk : {std::size_t{1}, std::size_t{7}, std::string_view::npos}) {
      const TriangleMesh mesh = read(text, chunk);
      EXPECT_EQ(mesh.positions, unix_lines.positions) << text;
      EXPECT_EQ(mesh.triangles, unix_lines.triangles) << text;
    }
  }
}

TEST(Obj, ContinuationsWithBlanksCommentsAndNames) {
  const TriangleMesh wanted = read(kThree + "v 1 1 0\nf 1 2 4 3\nf 2 4 3\n");
  const std::string vertices = kThree + "v 1 1 0\n";
  for (const std::string& text : {
           vertices + "f 1 2 \\ \n4 3\nf 2 4 3\n",                         // blanks after the backslash
           vertices + "f 1 2 \\\t\r\n4 3\r\nf 2 4 3\n",                    // and CR LF after those
           vertices + "f 1 2\\\n4 3\nf 2 4 3\n",                           // no blank before it
           vertices + "f 1 2 \\ # two more\n4 3\nf 2 4 3\n",               // a comment after it
           vertices + "f 1 2 \\\n# two\n  # more\n4 3\nf 2 4 3\n",         // lines of comment between
           vertices + "f 1 2 4 3 # c:\\temp\\\nf 2 4 3\n",                 // no continuation: a comment
           "# c:\\temp\\\n" + vertices + "f 1 2 4 3\nf 2 4 3\n",           // nor here
           "\xef\xbb\xbf# c:\\\n" + vertices + "f 1 2 4 3\nf 2 4 3\n",     // nor after a mark
           "mtllib c:\\models\\\n" + vertices + "f 1 2 4 3\nf 2 4 3\n",    // nor here: a name
           vertices + "usemtl a\\b\\\nf 1 2 4 3\n g x\\\nf 2 4 3\no\\\n",  // nor here
           vertices + "g a \\\nf 1 2 4 3\nf 1 2 4 3\nf 2 4 3\n",           // but here: a list of names goes on
       }) {
    for (const std::size_t chunk : {std::size_t{1}, std::string_view::npos}) {
      const TriangleMesh mesh = read(text, chunk);
      EXPECT_EQ(mesh.positions, wanted.positions) << text;
      EXPECT_EQ(mesh.triangles, wanted.triangles) << text;
    }
  }
}

TEST(Obj, NumbersInAllSpellings) {
  const TriangleMesh mesh = read("v +1 -1.5e+1 .5 1.0\nv 1. 1E-2 -0 0.1 0.2 0.3\nv 1e-400 5e-324 2\nf 1 2 3\n");
  EXPECT_EQ(mesh.positions[0], glm::dvec3(1, -15, 0.5));
  EXPECT_EQ(mesh.positions[1], glm::dvec3(1, 0.01, 0));
  EXPECT_EQ(mesh.positions[2].x, 0.0);
  EXPECT_EQ(mesh.positions[2].y, 5e-324);
}

/// Of the first triangle, by its winding.
glm::dvec3 plane_normal(const PlacedMesh& mesh) {
  const auto [a, b, c] = mesh.triangle(0);
  return glm::normalize(glm::cross(b - a, c - a));
}

TEST(Obj, NormalsFollowTheInverseTranspose) {
  glm::dmat4 m = glm::scale(glm::dmat4(1.0), glm::dvec3(2, 1, 1));
  m = glm::translate(glm::dmat4(1.0), glm::dvec3(5, 0, 0)) * m;
  const TriangleMesh mesh = read("v 0 0 0\nv -1 1 0\nv 0 0 1\nvn 30 30 0\nf 1//1 2//1 3//1\n");
  EXPECT_EQ(mesh.positions[1], glm::dvec3(-1, 1, 0)) << "the file's coordinates are the mesh's";
  EXPECT_NEAR(glm::length(mesh.normals[0] - glm::normalize(glm::dvec3(1, 1, 0))), 0.0, 1e-15);
  const PlacedMesh placed(mesh, Instance{.world_from_object = m});
  EXPECT_EQ(placed.position(1), glm::dvec3(3, 1, 0));
  EXPECT_NEAR(glm::length(placed.normal(0) - glm::normalize(glm::dvec3(0.5, 1, 0))), 0.0, 1e-15);
  EXPECT_NEAR(glm::dot(plane_normal(placed), placed.normal(0)), 1.0, 1e-15);
}

TEST(Obj, MirrorsKeepTheSideOfTheNormalsAndFlippingTurnsIt) {
  const TriangleMesh mesh = read(kThree + "vn 0 0 1\nf 1//1 2//1 3//1\n");
  const glm::dmat4 plain(1.0), across = glm::scale(plain, glm::dvec3(-1, 1, 1)),
                               along = glm::scale(plain, glm::dvec3(1, 1, -2));
  struct Case {
    glm::dmat4 m;
    bool flip;
    double side;  // of the world's Z axis, to which the normal points
  };
  for (const Case& c : {Case{plain, false, 1.0},
                        {across, false, 1.0},
                        {along, false, -1.0},
                        {across * along, false, -1.0},
                        {plain, true, -1.0},
                        {across, true, -1.0},
                        {along, true, 1.0},
                        {across * along, true, 1.0}}) {
    const PlacedMesh placed(mesh, Instance{.world_from_object = c.m, .flip_normals = c.flip});
    EXPECT_EQ(placed.normal(0), glm::dvec3(0, 0, c.side));
    EXPECT_EQ(plane_normal(placed), glm::dvec3(0, 0, c.side)) << "the winding follows the normals";
  }
}

struct BadObj {
  const char* what;
  std::string text;
  int line;
  int column;
  const char* says;
};
void PrintTo(const BadObj& bad, std::ostream* out) {
  *out << bad.what;
}

class BadMesh : public ::testing::TestWithParam<BadObj> {};

TEST_P(BadMesh, IsRefusedAtItsPlace) {
  const BadObj& bad = GetParam();
  Diagnostics diagnostics;
  EXPECT_FALSE(read_obj(memory_source(bad.text), "m.obj", {}, diagnostics).has_value());
  ASSERT_EQ(diagnostics.error_count(), 1u);
  const Diagnostic& error = diagnostics.list().back();
  EXPECT_EQ(error.position.line, bad.line) << to_string(error);
  EXPECT_EQ(error.position.column, bad.column) << to_string(error);
  EXPECT_NE(error.message.find(bad.says), std::string::npos) << to_string(error);
}

std::string name_of(const ::testing::TestParamInfo<BadObj>& info) {
  return info.param.what;
}

const BadObj kBadMeshes[] = {
    {"IndexTooLarge", kThree + "f 1 2 4\n", 4, 7, "index 4 of a vertex is out of range; the file has 3 so far"},
    {"IndexTooNegative", kThree + "f 1 2 -4\n", 4, 7, "index -4 of a vertex is out of range; the file has 3 so far"},
    {"ForwardReference", "v 0 0 0\nf 1 2 3\nv 1 0 0\nv 0 1 0\n", 2, 5, "the file has 1 so far"},
    {"IndexZero", kThree + "f 0 1 2\n", 4, 3, "indices count from 1"},
    {"IndexOverflow", kThree + "f 99999999999999999999 1 2\n", 4, 3, "too large"},
    {"IndexMin", kThree + "f -9223372036854775808 1 2\n", 4, 3, "out of range"},
    {"IndexJunk", kThree + "f 1 2 3x\n", 4, 7, "\"3x\" is not an index"},
    {"IndexFloat", kThree + "f 1 2 3.0\n", 4, 7, "not an index"},
    {"TextureIndexJunk", kThree + "f 1/x 2/1 3/1\n", 4, 5, "\"x\" is not an index"},
    {"NormalIndex", kThree + "vn 0 0 1\nf 1//1 2//2 3//1\n", 5, 11,
     "index 2 of a normal is out of range; the file has 1 so far"},
    {"FourIndices", kThree + "f 1/1/1/1 2 3\n", 4, 3, "more than 3 indices"},
    {"ThreeSlashes", kThree + "f 1/// 2 3\n", 4, 3, "more than 3 indices"},
    {"OnlySlashes", kThree + "f 1 // 3\n", 4, 5, "no corner of a face"},
    {"LeadingSlash", kThree + "f /1 2 3\n", 4, 3, "no corner of a face"},
    {"TwoCorners", kThree + "f 1 2\n", 4, 1, "a face has 2 corners"},
    {"NoCorners", kThree + "f\n", 4, 1, "a face has 0 corners"},
    {"CommentCorners", kThree + "f 1 2 # 3\n", 4, 1, "a face has 2 corners"},
    {"TwoCoordinates", "v 1 2\n" + kThree + "f 1 2 3\nf 1 3 4\n", 1, 1, "a vertex has 2 numbers; it needs 3"},
    {"NineCoordinates", "v 1 2 3 4 5 6 7 8\n" + kThree + "f 1 2 3\n", 1, 17, "more than 7"},
    {"NaN", "v 1 nan 3\n" + kThree + "f 4 3 2 1\n", 1, 5, "not a finite number"},
    {"Infinity", "v 1 -inf 3\n" + kThree + "f 1 2 3\n", 1, 5, "not a finite number"},
    {"Overflow", "v 1 2 1e400\n" + kThree + "f 1 2 3\n", 1, 7, "too large"},
    {"Hex", "v 0x1 2 3\n" + kThree + "f 1 2 3\n", 1, 3, "not a number"},
    {"DecimalComma", "v 1,5 2 3\n" + kThree + "f 1 2 3\n", 1, 3, "not a number"},
    {"FarVertex", "v 1 2 1e30\n" + kThree + "f 1 2 3\n", 1, 1, "coordinates up to 1000000000"},
    {"ShortNormal", "vn 0 1\n" + kThree + "f 1//1 2 3\nf 1//1 2 3\n", 1, 1, "a normal has 2 numbers; it needs 3"},
    {"LfsPointer", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", 1, 1,
     "Git LFS pointer, not the file itself; fetch it with `git lfs pull`"},
    {"AnnexPointer", "/annex/objects/SHA256E-s1234--0a1b.obj\n", 1, 1,
     "git-annex pointer, not the file itself; fetch it with `git annex get`"},
    {"AnnexLinkAsText", "../.git/annex/objects/x1/Qz/SHA256E-s9--ab.obj/SHA256E-s9--ab.obj", 1, 1, "git-annex pointer"},
    {"Continued", kThree + "f 1 \\\n  2 \\\n  9\n", 6, 3, "index 9"},
    {"Binary", std::string("glTF\0\0\0\2", 8), 1, 1, "binary data"},
    {"LongLine", kThree + "f" + std::string(5 << 20, ' ') + "1 2 3", 4, 1, "more than 4194304 bytes"},
    {"LongContinuedLine",
     [] {
       std::string text = "f ";
       while (text.size() < (6u << 20)) text += "1 \\\n";
       return kThree + text;
     }(),
     4, 1, "more than 4194304 bytes"},
    {"TooManyCorners",
     [] {
       std::string text = kThree + "f";
       for (int i = 0; i < 70000; ++i) text += " 1";
       return text;
     }(),
     4, 131075, "more than 65536 corners"},
};
INSTANTIATE_TEST_SUITE_P(Obj, BadMesh, ::testing::ValuesIn(kBadMeshes), name_of);

TEST(Obj, WarnsOnceAboutUnknownLinesAndCountsDegenerateTriangles) {
  Diagnostics diagnostics;
  const auto mesh = read_obj(memory_source("hello\nworld\nl 1 2\n" + kThree + "f 1 2 3\nf 1 1 2\nf 1 2 2\n"), "m.obj",
                             {}, diagnostics);
  ASSERT_TRUE(mesh.has_value());
  EXPECT_EQ(mesh->triangles.size(), 3u) << "triangles without area are kept";
  ASSERT_EQ(diagnostics.list().size(), 2u) << all_messages(diagnostics);
  EXPECT_EQ(to_string(diagnostics.list()[0]).substr(0, 10), "m.obj:1:1:");
  EXPECT_NE(diagnostics.list()[0].message.find("\"hello\""), std::string::npos);
  EXPECT_NE(diagnostics.list()[1].message.find("2 of 3 triangles have no area"), std::string::npos);
}

TEST(Obj, AFileWithoutFacesIsAnEmptyMesh) {
  for (const std::string& text : {std::string(), std::string("# nothing\n"), kThree}) {
    Diagnostics diagnostics;
    const auto mesh = read_obj(memory_source(text), "m.obj", {}, diagnostics);
    ASSERT_TRUE(mesh.has_value());
    EXPECT_TRUE(mesh->triangles.empty() && mesh->positions.empty() && mesh->normals.empty());
    EXPECT_TRUE(diagnostics.list().empty());
  }
}

TEST(Obj, AMeshWithoutFacesIsLeftOutWhereTheSceneHasOthers) {
  TemporaryFolder folder;
  folder.write("empty.obj", kThree);
  folder.write("full.obj", kThree + "f 1 2 3\n");
  const auto mesh = [](const std::string& file) {
    return "<mesh type=\"obj\"><string name=\"filename\" value=\"" + file +
           "\"/><emitter type=\"area\"><color name=\"radiance\" value=\"1 1 1\"/></emitter></mesh>\n";
  };
  Diagnostics diagnostics;
  const auto file =
      read_scene_file(folder.write("s.xml", scene_around(mesh("empty.obj") + mesh("full.obj"))), {}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  EXPECT_EQ(std::get<Scene>(*file).instances.size(), 1u);
  EXPECT_EQ(std::get<Scene>(*file).instances.front().name, "full.obj");
  EXPECT_EQ(all_messages(diagnostics),
            folder.path("s.xml") + ":2:49: the mesh \"empty.obj\" has no faces; it is left out\n");
  Diagnostics alone;
  EXPECT_FALSE(read_scene_file(folder.write("t.xml", scene_around(mesh("empty.obj"))), {}, alone));
  EXPECT_EQ(all_messages(alone), folder.path("t.xml") +
                                     ":2:49: the mesh \"empty.obj\" has no faces, nor has any "
                                     "other; export the surface as faces\n");
}

TEST(Obj, BackslashesInFileNames) {
  TemporaryFolder folder;
  folder.write("meshes/a.obj", kThree + "f 1 2 3\n");
  folder.write("b\\c.obj", kThree + "f 1 2 3\n");
  const auto read_mesh = [&](const std::string& name, Diagnostics& diagnostics) {
    const std::string mesh = "<mesh type=\"obj\"><string name=\"filename\" value=\"" + name + "\"/></mesh>";
    return read_scene_file(folder.write("s.xml", scene_around(mesh)), {}, diagnostics).has_value();
  };
  Diagnostics slashed, exact, missing;
  EXPECT_TRUE(read_mesh("meshes\\a.obj", slashed));
  ASSERT_EQ(slashed.list().size(), 1u);
  EXPECT_EQ(slashed.list()[0].severity, Severity::note);
  EXPECT_EQ(slashed.list()[0].message, "\"meshes\\a.obj\" is read as \"meshes/a.obj\"");
  EXPECT_TRUE(read_mesh("b\\c.obj", exact)) << "a name of Unix may hold a backslash";
  EXPECT_TRUE(exact.list().empty());
  EXPECT_FALSE(read_mesh("meshes\\b.obj", missing));
  EXPECT_NE(all_messages(missing).find("meshes/b.obj: cannot open the file"), std::string::npos)
      << all_messages(missing);
}

TEST(Obj, EmitterWithoutAreaIsAnError) {
  TemporaryFolder folder;
  folder.write("flat.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n");
  const std::string scene = folder.write(
      "s.xml", scene_around("<mesh type=\"obj\"><string name=\"filename\" value=\"flat.obj\"/>\n<emitter type=\"area\">"
                            "<color name=\"radiance\" value=\"1 1 1\"/></emitter></mesh>"));
  try {
    read_scene(scene);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("s.xml:3:1: the emitter's mesh \"flat.obj\" has no area"),
              std::string::npos)
        << error.what();
  }
}

// ---- Polygons

double area2(const std::vector<glm::dvec3>& p) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < p.size(); ++i) sum += glm::cross(p[i], p[(i + 1) % p.size()]);
  return glm::length(sum);
}

/// A triangulation is right if its triangles all have the polygon's orientation and their areas add up to the
/// polygon's: then they can neither overlap nor leave it.
void expect_triangulation(const std::vector<glm::dvec3>& polygon) {
  std::vector<PolygonTriangle> triangles;
  std::int64_t work = 1'000'000'000;
  EXPECT_TRUE(triangulate(polygon, triangles, work));
  ASSERT_EQ(triangles.size(), polygon.size() - 2);
  glm::dvec3 normal(0.0);
  for (std::size_t i = 0; i < polygon.size(); ++i) normal += glm::cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  normal = glm::normalize(normal);
  double sum = 0.0;
  for (const PolygonTriangle& t : triangles) {
    const double area = glm::dot(glm::cross(polygon[t.y] - polygon[t.x], polygon[t.z] - polygon[t.x]), normal);
    EXPECT_GE(area, -1e-9 * area2(polygon));
    sum += area;
  }
  EXPECT_NEAR(sum, area2(polygon), 1e-9 * area2(polygon));
}

std::vector<glm::dvec3> lift(const std::vector<glm::dvec2>& flat, const glm::dmat4& m) {
  std::vector<glm::dvec3> polygon;
  polygon.reserve(flat.size());
  for (const glm::dvec2& p : flat) polygon.emplace_back(m * glm::dvec4(p, 0.0, 1.0));
  return polygon;
}

TEST(Polygon, ConcaveShapesInAnyPosition) {
  const std::vector<std::vector<glm::dvec2>> shapes = {
      {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
      {{0, 0}, {2, 0}, {0.5, 0.5}, {0, 2}},                              // arrow: the fan from corner 0 works
      {{2, 0}, {0.5, 0.5}, {0, 2}, {0, 0}},                              // the same, where a fan from corner 0 does not
      {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {3, 2}, {3, 3}, {0, 3}},  // C
      {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}},  // U with collinear corners
      // a square with a square hole, joined by a bridge that is walked twice
      {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}},
  };
  const glm::dmat4 poses[] = {
      glm::dmat4(1.0), glm::rotate(glm::dmat4(1.0), glm::pi<double>(), glm::dvec3(1, 0, 0)),
      glm::rotate(glm::dmat4(1.0), 1.0, glm::dvec3(1, 2, 3)),
      glm::translate(glm::dmat4(1.0), glm::dvec3(1e4)) * glm::rotate(glm::dmat4(1.0), 1.6, glm::dvec3(0, 1, 0)),
      glm::scale(glm::dmat4(1.0), glm::dvec3(1e-3))};
  for (const auto& shape : shapes) {
    for (const glm::dmat4& pose : poses) {
      expect_triangulation(lift(shape, pose));
      expect_triangulation(lift({shape.rbegin(), shape.rend()}, pose));
    }
  }
}

TEST(Polygon, RandomStarShapes) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> radius(0.1, 1.0);
  for (int n = 4; n < 200; n += 7) {
    std::vector<glm::dvec2> flat;
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * glm::pi<double>() * i / n;
      flat.push_back(radius(random) * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
    expect_triangulation(lift(flat, glm::rotate(glm::dmat4(1.0), 0.3 * n, glm::dvec3(1, 1, 0))));
  }
}

TEST(Polygon, SpiralThatDefeatsFans) {
  std::vector<glm::dvec2> flat;
  for (int i = 0; i <= 60; ++i) flat.push_back((1.0 + 0.1 * i) * glm::dvec2(std::cos(0.3 * i), std::sin(0.3 * i)));
  for (int i = 60; i >= 0; --i) flat.push_back((1.5 + 0.1 * i) * glm::dvec2(std::cos(0.3 * i), std::sin(0.3 * i)));
  expect_triangulation(lift(flat, glm::dmat4(1.0)));
}

TEST(Polygon, CrossingAndDegeneratePolygonsEnd) {
  const std::vector<std::vector<glm::dvec3>> polygons = {
      {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},                                   // bow tie
      std::vector<glm::dvec3>(50, glm::dvec3(1, 2, 3)),                               // one point
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1.5, 0, 0}},                      // a line
      {{0, 1, 0}, {0.6, -0.8, 0}, {-0.95, 0.3, 0}, {0.95, 0.3, 0}, {-0.6, -0.8, 0}},  // pentagram
      {{0, 0, 0}, {1e-300, 0, 0}, {1e9, 1e9, 0}, {0, 1e-300, 0}},
  };
  for (const auto& polygon : polygons) {
    std::vector<PolygonTriangle> triangles;
    std::int64_t work = 1'000'000;
    triangulate(polygon, triangles, work);
    EXPECT_EQ(triangles.size(), polygon.size() - 2);
    for (const PolygonTriangle& t : triangles) EXPECT_LT(std::max({t.x, t.y, t.z}), polygon.size());
  }
}

TEST(Polygon, WorkIsBounded) {
  std::vector<glm::dvec3> comb;
  constexpr int kCorners = 2000;
  comb.reserve(kCorners);
  for (int i = 0; i < kCorners; ++i) comb.emplace_back(i, i % 2 == 0 ? 1.0 : 100.0, 0.0);
  comb.emplace_back(2000, 0, 0);
  comb.emplace_back(0, 0, 0);
  std::vector<PolygonTriangle> triangles;
  std::int64_t work = 1000;
  EXPECT_FALSE(triangulate(comb, triangles, work));
  EXPECT_EQ(triangles.size(), comb.size() - 2);
}

TEST(Obj, ConcaveFaceOfAFile) {
  const TriangleMesh mesh = read("v 2 0 0\nv 0.5 0.5 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4\n");
  ASSERT_EQ(mesh.triangles.size(), 2u);
  double area = 0.0;
  for (const glm::uvec3& t : mesh.triangles)
    area += triangle_area({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
  EXPECT_NEAR(area, 1.0, 1e-12);
}

TEST(Obj, ManyNormalsOfOneVertexStayLinear) {
  // Every face names vertex 1 with a normal of its own: a list per vertex would take quadratic time.
  std::string text = kThree;
  constexpr int kCount = 200000;
  for (int i = 0; i < kCount; ++i) text += "vn 0 0 1\nf 1//-1 2//-1 3//-1\n";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(read(text).positions.size(), 3u * kCount);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

/// An OBJ file of as many positions, normals and triangles, of the same numbers at all corners; made line by line.
ByteSource mesh_source(long count) {
  return [count, line = 0L](char* buffer, std::size_t capacity) mutable {
    std::size_t size = 0;
    for (; line < 3 * count && size + 100 < capacity; ++line) {
      const long i = line % count, next = (i + 1) % count + 1, other = (i + 1000) % count + 1;
      char* const end = line < count ? fmt::format_to(buffer + size, "v {} {} {}\n", i % 1000, i / 1000, i * 7 % 13)
                        : line < 2 * count
                            ? fmt::format_to(buffer + size, "vn {} 1 0\n", i % 1000)
                            : fmt::format_to(buffer + size, "f {0}//{0} {1}//{1} {2}//{2}\n", i + 1, next, other);
      size = static_cast<std::size_t>(end - buffer);
    }
    return size;
  };
}

/// Largest resident memory of this program so far, in bytes. Other than ru_maxrss it begins anew with exec.
long largest_memory() {
  std::ifstream status("/proc/self/status");
  long kibibytes = 0;
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") status >> kibibytes;
  }
  return kibibytes * 1024;
}

TEST(Obj, TextureCoordinatesSplitVertices) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0 7\nvt 0.5\nf 1/1 2/2 3/3\nf 2/3 4/1 3/3\nf 1/1 2/2 4\n";
  Diagnostics diagnostics;
  const auto mesh = read_obj(memory_source(text), "m.obj", {}, diagnostics);
  ASSERT_TRUE(mesh);
  EXPECT_TRUE(diagnostics.list().empty()) << all_messages(diagnostics);
  EXPECT_EQ(mesh->triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {3, 4, 2}, {0, 1, 5}}));
  EXPECT_EQ(mesh->positions,
            (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}}));
  ASSERT_EQ(mesh->uv_sets.size(), 1u);
  EXPECT_EQ(mesh->uv_sets[0], (std::vector<glm::vec2>{{0, 0}, {1, 0}, {.5f, 0}, {.5f, 0}, {0, 0}, {0, 0}}))
      << "0 0 where a corner has none";
  // Where nothing uses them the mesh is what it would be without.
  const auto plain = read_obj(memory_source(text), "m.obj", {.uv = false}, diagnostics);
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {1, 3, 2}, {0, 1, 3}}));
  EXPECT_TRUE(plain->uv_sets.empty());
}

TEST(Obj, NormalsAndTextureCoordinatesTogether) {
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\nvn 1 0 0\n"
      "f 1/1/1 2/1/1 3/1/1\nf 1/2/1 2/1/1 3/1/2\nf 1/2/1 2/1/1 3/2/2\nf 1/2/1 2/1/1 3/1/2\n";
  Diagnostics diagnostics;
  const auto mesh = read_obj(memory_source(text), "m.obj", {}, diagnostics);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {3, 1, 4}, {3, 1, 5}, {3, 1, 4}}));
  EXPECT_EQ(mesh->normals.at(4), glm::dvec3(1, 0, 0));
  EXPECT_EQ(mesh->uv_sets.at(0).at(5), glm::vec2(1, 1));
}

TEST(Obj, BadTextureCoordinatesAreNone) {
  for (const char* bad : {"vt x 0\n", "vt 1e39 0\n"}) {
    Diagnostics diagnostics;
    const auto mesh = read_obj(
        memory_source("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n" + std::string(bad) + "f 1/2 2/1 3/1\n"),
        "m.obj", {}, diagnostics);
    ASSERT_TRUE(mesh);
    EXPECT_TRUE(mesh->uv_sets.empty());
    ASSERT_EQ(diagnostics.list().size(), 1u);
    EXPECT_NE(all_messages(diagnostics).find("texture coordinates are ignored, here and below"), std::string::npos);
  }
}

TEST(Obj, ColorsOfVertices) {
  const std::string faces = "f 1 2 3\n";
  Diagnostics diagnostics;
  const auto mesh =
      read_obj(memory_source("v 0 0 0 1 0 0.5\nv 1 0 0 0 1 0 1\nv 0 1 0\n" + faces), "m.obj", {}, diagnostics);
  ASSERT_TRUE(mesh);
  ASSERT_EQ(mesh->vertex_colors.size(), 3u);
  EXPECT_NEAR(mesh->vertex_colors[0].z, 0.214041, 1e-5) << "0.5 as sRGB";
  EXPECT_EQ(mesh->vertex_colors[1], glm::vec3(0, 1, 0));
  EXPECT_EQ(mesh->vertex_colors[2], glm::vec3(1));
  EXPECT_EQ(all_messages(diagnostics), "m.obj: 1 of 3 vertices have no colour; they are white\n");
  Diagnostics bad;
  const auto none =
      read_obj(memory_source("v 0 0 0 1 0 0\nv 1 0 0 255 1 0\nv 0 1 0 1 1 1\n" + faces), "m.obj", {}, bad);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->vertex_colors.empty());
  EXPECT_NE(all_messages(bad).find("m.obj:2:1: the colour 255 1 0 of this vertex is not between 0 and 1"),
            std::string::npos);
}

TEST(Obj, TablesAreFreedAsSoonAsTheyAreRead) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep memory that is freed";
#endif
  // So many that every table is given back to the system when it is freed, in a program of its own: after other tests,
  // tables would be taken from memory that they have left.
  constexpr long kCount = 1L << 21;
  constexpr const char* kAlone = "ETENDUE_TEST_ALONE";
  if (std::getenv(kAlone) != nullptr) {
    const long before = largest_memory();
    Diagnostics diagnostics;
    const auto mesh = read_obj(mesh_source(kCount), "m.obj", {}, diagnostics);
    if (!mesh || mesh->positions.size() != kCount || mesh->normals.size() != kCount) _exit(255);
    _exit(static_cast<int>((largest_memory() - before) / kCount));
  }
  const pid_t child = fork();
  if (child == 0) {
    setenv(kAlone, "1", 1);
    execl("/proc/self/exe", "alone", "--gtest_filter=Obj.TablesAreFreedAsSoonAsTheyAreRead", "--gtest_brief=1",
          static_cast<char*>(nullptr));
    _exit(254);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  // While the positions are written: triangles 12, old and new positions 24 each, normals 24, pairs 8.
  EXPECT_GT(WEXITSTATUS(status), 60) << "bytes a vertex; fewer than the result has cannot be";
  EXPECT_LT(WEXITSTATUS(status), 105) << "bytes a vertex; with nothing freed it would be 132";
}

}  // namespace
}  // namespace etendue::testing
