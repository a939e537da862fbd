// PLY files: three forms of data, any order of elements and properties, and what is said of files that lie.

#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "formats/ply/ply_reader.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

struct Ply {
  std::optional<TriangleMesh> mesh;
  Diagnostics diagnostics;
  std::string messages() const { return all_messages(diagnostics); }
};

Ply read(std::string_view text, const MeshContent& content = {}, std::size_t chunk = std::string_view::npos) {
  Ply ply;
  ply.mesh = read_ply(memory_source(text, chunk), "m.ply", content, ply.diagnostics, text.size());
  return ply;
}

/// Numbers as a file holds them.
class Bytes {
 public:
  explicit Bytes(bool big) : big_(big) {}
  template <typename T>
  Bytes& put(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (big_ == (std::endian::native == std::endian::little)) std::reverse(bytes, bytes + sizeof(T));
    text.append(bytes, sizeof(T));
    return *this;
  }
  std::string text;

 private:
  bool big_;
};

std::string header(const std::string& format, const std::string& lines) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + lines + "end_header\n";
}
const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFaces = "property list uchar int vertex_indices\n";
std::string ascii(const std::string& vertices, const std::string& faces, const std::string& data) {
  return header("ascii", "element vertex " + vertices + "element face " + faces) + data;
}
const std::string kThree = "0 0 0\n1 0 0\n0 1 0\n";

TEST(Ply, AsciiTriangle) {
  const Ply ply = read(ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "3 0 1 2\n"));
  ASSERT_TRUE(ply.mesh) << ply.messages();
  EXPECT_EQ(ply.messages(), "");
  EXPECT_EQ(ply.mesh->positions, (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(ply.mesh->triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
  EXPECT_TRUE(ply.mesh->normals.empty() && ply.mesh->uv_sets.empty() && ply.mesh->vertex_colors.empty());
}

/// Everything at once, in both byte orders: odd types, odd order, properties and elements that are not known.
std::string everything(bool big) {
  Bytes b(big);
  const auto vertex = [&](double x, float y, std::int16_t z, float nx, std::uint8_t red, float s) {
    b.put<std::uint16_t>(2).put<float>(9).put<float>(9);  // list "weights"
    b.put(red).put<std::uint8_t>(255).put<std::uint8_t>(0).put<std::uint8_t>(7);
    b.put(s).put<float>(0.25f).put(z).put(y).put(x).put<std::int8_t>(-3).put(nx).put<float>(0).put<float>(0);
  };
  b.put<double>(1.5).put<double>(2.5);  // element "camera"
  const auto faces = [&] {
    b.put<float>(0.5f).put<float>(0.25f).put<float>(1).put<std::uint32_t>(4);
    for (const int i : {0, 1, 2, 3}) b.put(static_cast<std::uint16_t>(i));
    b.put<std::int32_t>(11);
    b.put<float>(1).put<float>(1).put<float>(0).put<std::uint32_t>(3);
    for (const int i : {1, 4, 2}) b.put(static_cast<std::uint16_t>(i));
    b.put<std::int32_t>(12);
  };
  faces();
  vertex(0, 0, 0, 2, 128, 0.5f);
  vertex(1, 0, 0, -2, 255, 0.25f);
  vertex(1, 1, 0, 1, 0, 0);
  vertex(0, 1, 0, 1, 0, 1);
  vertex(0x1.23456789ap0, 0.1f, -300, 1, 0, 1);
  return header(big ? "binary_big_endian" : "binary_little_endian",
                "element camera 2\nproperty double f\n"
                "element face 2\nproperty float red\nproperty float green\nproperty float blue\n"
                "property list uint ushort vertex_index\nproperty int flags\n"
                "element vertex 5\nproperty list ushort float weights\nproperty uchar red\nproperty uchar green\n"
                "property uchar blue\nproperty uchar alpha\nproperty float s\nproperty float t\nproperty short z\n"
                "property float32 y\nproperty double x\nproperty char odd\nproperty float nx\nproperty float ny\n"
                "property float nz\n") +
         b.text;
}

TEST(Ply, BinaryOfBothByteOrdersAndAnyOrderOfThings) {
  for (const bool big : {false, true}) {
    for (const std::size_t chunk : {std::size_t{1}, std::size_t{7}, std::string_view::npos}) {
      const Ply ply = read(everything(big), {}, chunk);
      ASSERT_TRUE(ply.mesh) << ply.messages();
      EXPECT_EQ(ply.messages(), "");
      const TriangleMesh& mesh = *ply.mesh;
      EXPECT_EQ(mesh.positions,
                (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0x1.23456789ap0, 0.1f, -300}}));
      EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}));
      EXPECT_EQ(mesh.normals[0], glm::dvec3(1, 0, 0));
      EXPECT_EQ(mesh.normals[1], glm::dvec3(-1, 0, 0));
      ASSERT_EQ(mesh.uv_sets.size(), 1u);
      EXPECT_EQ(mesh.uv_sets[0][1], glm::vec2(0.25f, 0.25f));
      EXPECT_EQ(mesh.face_colors, (std::vector<glm::vec3>{{0.5f, 0.25f, 1}, {0.5f, 0.25f, 1}, {1, 1, 0}}))
          << "floats are linear; a polygon gives its colour to its triangles";
      EXPECT_NEAR(mesh.vertex_colors[0].x, 0.21586, 1e-5) << "128 of 255 as sRGB";
      EXPECT_EQ(mesh.vertex_colors[0].y, 1.0f);
      EXPECT_EQ(mesh.vertex_colors[0].z, 0.0f);
    }
  }
}

TEST(Ply, AsciiSaysTheSameAsBinary) {
  const std::string text =
      header("ascii",
             "element face 1\nproperty list char char vertex_index\nelement vertex 3\n"
             "property float nz\nproperty float ny\nproperty float nx\nproperty list int int skip\n"
             "property float z\nproperty double y\nproperty uint8 x\nproperty float u\nproperty float v\n") +
      "3 0 1 2 1 0 0 0 0 0 0 .5 1 1 0 0 2 -1 -2 0 0 2e0 .25 1\n1 0 0 0 0 1e0 0 0 0\r\n";
  const Ply ply = read(text);
  ASSERT_TRUE(ply.mesh) << ply.messages();
  EXPECT_EQ(ply.mesh->positions, (std::vector<glm::dvec3>{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(ply.mesh->normals, (std::vector<glm::dvec3>(3, {0, 0, 1})));
  EXPECT_EQ(ply.mesh->uv_sets[0], (std::vector<glm::vec2>{{.5f, 1}, {.25f, 1}, {0, 0}}));
}

TEST(Ply, WhatIsNotWantedIsNotKept) {
  const Ply ply = read(everything(false), {.uv = false, .colors = false});
  ASSERT_TRUE(ply.mesh);
  EXPECT_TRUE(ply.mesh->uv_sets.empty());
  EXPECT_TRUE(ply.mesh->vertex_colors.empty());
  EXPECT_TRUE(ply.mesh->face_colors.empty());
  EXPECT_FALSE(ply.mesh->normals.empty());
}

TEST(Ply, AttributesByName) {
  const std::string text =
      header("ascii", "element vertex 3\n" + kXyz + "property float heat_0\nproperty float r\nproperty float g\n" +
                          "property float b\nelement face 1\n" + kFaces +
                          "property float tint_0\nproperty float tint_1\nproperty float tint_2\n") +
      "0 0 0 7 1 1 1\n1 0 0 8 1 1 1\n0 1 0 9 1 1 1\n3 0 1 2 0.5 0.25 2\n";
  const Ply heat = read(text, {.uv = false, .attribute = "heat"});
  ASSERT_TRUE(heat.mesh.has_value());
  EXPECT_EQ(heat.mesh->vertex_colors, (std::vector<glm::vec3>{glm::vec3(7), glm::vec3(8), glm::vec3(9)}));
  EXPECT_TRUE(heat.mesh->face_colors.empty());
  const Ply tint = read(text, {.uv = false, .attribute = "tint"});
  ASSERT_TRUE(tint.mesh.has_value());
  EXPECT_EQ(tint.mesh->face_colors, (std::vector<glm::vec3>{{0.5f, 0.25f, 2.0f}}));
  EXPECT_TRUE(tint.mesh->vertex_colors.empty());
}

TEST(Ply, EndsOfHeaderLines) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string head = header("binary_little_endian", "element vertex 1\n" + kXyz);
    for (std::size_t at = head.find('\n'); at != std::string::npos; at = head.find('\n', at + std::strlen(end)))
      head.replace(at, 1, end);
    // The first byte of the data is an LF: it belongs to the line's end only where the lines end with CR LF.
    Bytes b(false);
    b.put<std::uint32_t>(0x3f80000a).put<float>(2).put<float>(3);
    std::string face = head;
    face.insert(face.find("end_header"),
                fmt::format("element face 1{0}property list uchar uchar vertex_index{0}", end));
    const Ply ply = read(face + b.text + std::string("\x03\0\0\0", 4));
    ASSERT_TRUE(ply.mesh) << ply.messages();
    EXPECT_EQ(ply.mesh->positions.at(0).x, std::bit_cast<float>(0x3f80000au)) << "lines end with " << end;
    EXPECT_EQ(ply.mesh->positions.at(0).z, 3.0);
  }
  // Only the last line ends with CR LF, as one exporter does.
  const Ply odd = read("ply\nformat ascii 1.0\nelement vertex 3\n" + kXyz + "element face 1\n" + kFaces +
                       "end_header\r\n" + kThree + "3 0 1 2");
  EXPECT_TRUE(odd.mesh) << odd.messages();
}

TEST(Ply, PolygonsAreCutWhereverTheVerticesStand) {
  // A concave pentagon: the fan from its first corner would cover what lies outside.
  const std::string vertices = "2 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n", face = "5 0 1 2 3 4\n";
  const auto check = [](const std::string& text) {
    const Ply ply = read(text);
    ASSERT_TRUE(ply.mesh) << ply.messages();
    ASSERT_EQ(ply.mesh->triangles.size(), 3u);
    double area = 0;
    for (const glm::uvec3& t : ply.mesh->triangles) {
      const auto& p = ply.mesh->positions;
      area += 0.5 * glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]).z;
    }
    EXPECT_NEAR(area, 6.0, 1e-12);
  };
  check(ascii("5\n" + kXyz, "1\n" + kFaces, vertices + face));
  check(header("ascii", "element face 1\n" + kFaces + "element vertex 5\n" + kXyz) + face + vertices);
}

TEST(Ply, StripsOfTriangles) {
  const Ply ply = read(
      header("ascii", "element vertex 5\n" + kXyz + "element tristrips 1\nproperty list int int vertex_indices\n") +
      kThree + "1 1 0\n0 2 0\n9 0 1 2 3 -1 4 2 3 3\n");
  ASSERT_TRUE(ply.mesh) << ply.messages();
  EXPECT_EQ(ply.mesh->triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {2, 1, 3}, {4, 2, 3}}));
}

TEST(Ply, VerticesThatNoFaceUsesAreLeftOutWhateverTheyHold) {
  const Ply ply = read(ascii("5\n" + kXyz + "property float u\nproperty float v\n", "1\n" + kFaces,
                             "nan 0 0 1 1\n0 0 0 2 2\n1 0 0 3 3\n1e30 0 0 4 4\n0 1 0 5 5\n3 1 2 4\n"));
  ASSERT_TRUE(ply.mesh) << ply.messages();
  EXPECT_EQ(ply.mesh->positions, (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(ply.mesh->uv_sets[0], (std::vector<glm::vec2>{{2, 2}, {3, 3}, {5, 5}}));
  EXPECT_EQ(ply.mesh->triangles[0], glm::uvec3(0, 1, 2));
}

TEST(Ply, NormalsWithoutADirection) {
  const std::string normals = "property float nx\nproperty float ny\nproperty float nz\n";
  const Ply some =
      read(ascii("3\n" + kXyz + normals, "1\n" + kFaces, "0 0 0 0 0 0\n1 0 0 1 0 0\n0 1 0 nan 1 0\n3 0 1 2\n"));
  ASSERT_TRUE(some.mesh) << some.messages();
  EXPECT_EQ(some.mesh->normals, (std::vector<glm::dvec3>{{0, 0, 1}, {1, 0, 0}, {0, 0, 1}}));
  EXPECT_NE(some.messages().find("2 of 3 vertex normals have no direction"), std::string::npos);
  const Ply none =
      read(ascii("3\n" + kXyz + normals, "1\n" + kFaces, "0 0 0 0 0 0\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n"));
  ASSERT_TRUE(none.mesh);
  EXPECT_TRUE(none.mesh->normals.empty());
}

TEST(Ply, WhatIsOnlyWorthAWarning) {
  const Ply ply = read("ply\nformat ascii 1.0\nCreated by a program\nelement vertex 4\n" + kXyz + "element face 3\n" +
                       kFaces + "end_header\n" + kThree + "2 0 0\n2 0 1\n3 0 1 2\n3 0 1 3\n");
  ASSERT_TRUE(ply.mesh) << ply.messages();
  EXPECT_EQ(ply.messages(),
            "m.ply:3:1: header lines that start with \"Created\" are unknown and ignored, here and below\n"
            "m.ply: 1 faces have fewer than 3 corners; they are left out\n"
            "m.ply: 1 of 2 triangles have no area; no ray hits them\n");
  const Ply points = read(header("ascii", "element vertex 3\n" + kXyz) + kThree);
  ASSERT_TRUE(points.mesh);
  EXPECT_TRUE(points.mesh->triangles.empty() && points.mesh->positions.empty());
  EXPECT_TRUE(read(header("ascii", "element nothing 99999999999999\nelement vertex 0\n" + kXyz)).mesh);
}

struct BadPly {
  const char* what;
  std::string text;
  const char* says;
};
void PrintTo(const BadPly& bad, std::ostream* out) {
  *out << bad.what;
}
class BadPlyFile : public ::testing::TestWithParam<BadPly> {};

TEST_P(BadPlyFile, IsRefusedInASentence) {
  for (const std::size_t chunk : {std::size_t{1}, std::string_view::npos}) {
    const Ply ply = read(GetParam().text, {}, chunk);
    EXPECT_FALSE(ply.mesh);
    ASSERT_EQ(ply.diagnostics.error_count(), 1u) << ply.messages();
    EXPECT_EQ(ply.messages(), std::string(GetParam().says) + "\n");
  }
}

std::string binary(const std::string& lines, const std::string& data) {
  return header("binary_little_endian", lines) + data;
}
const BadPly kBadPly[] = {
    {"Empty", "", "m.ply:1:1: the file ends within its header"},
    {"NotPly", "v 0 0 0\n", "m.ply:1:1: a PLY file begins with a line \"ply\"; this one does not"},
    {"Lfs", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12\n",
     "m.ply:1:1: this is a Git LFS pointer, not the file itself; fetch it with `git lfs pull`"},
    {"EndsInHeader", "ply\nformat ascii 1.0\nelement vertex 3", "m.ply:3:1: the file ends within its header"},
    {"NoFormat", "ply\nend_header\n",
     "m.ply:2:1: the header does not give its format; it needs a line like \"format ascii 1.0\""},
    {"OddFormat", "ply\nformat binary 1.0\nend_header\n",
     "m.ply:2:8: \"binary\" is not a format; known are ascii, binary_little_endian and binary_big_endian"},
    {"OddVersion", "ply\nformat ascii 2.0\nend_header\n",
     "m.ply:2:14: the format has version \"2.0\"; 1.0 is supported"},
    {"TwoFormats", "ply\nformat ascii 1.0\nformat ascii 1.0\nend_header\n", "m.ply:3:1: the format is given twice"},
    {"LongLine", "ply\ncomment " + std::string(5000, 'x') + "\n", "m.ply:2:1: this line has more than 4096 bytes"},
    {"LongHeader",
     "ply\nformat ascii 1.0\n" +
         [] {
           std::string s;
           for (int i = 0; i < 10001; ++i) s += "comment\n";
           return s;
         }(),
     "m.ply:10002:1: the header has more than 10000 lines"},
    {"NegativeCount", header("ascii", "element vertex -1\n"), "m.ply:4:16: there cannot be -1 of an element"},
    {"OddCount", header("ascii", "element vertex many\n"), "m.ply:4:16: \"many\" is not an integer; write it like 640"},
    {"HugeCount", header("ascii", "element vertex 99999999999999999999\n"),
     "m.ply:4:16: \"99999999999999999999\" is too large to be an integer"},
    {"TooManyVertices", header("ascii", "element vertex 99999999\n" + kXyz),
     "m.ply:4:16: the file has 99999999 vertices; at most 33554432 are supported"},
    {"TooManyFaces", header("ascii", "element vertex 0\n" + kXyz + "element face 99999999\n" + kFaces),
     "m.ply:8:14: the file has 99999999 faces; at most 33554432 are supported"},
    {"TwoElements", header("ascii", "element vertex 0\nelement vertex 0\n"),
     "m.ply:5:16: the element \"vertex\" is given twice"},
    {"TwoProperties", header("ascii", "element vertex 0\nproperty float x\nproperty int x\n"),
     "m.ply:6:14: the property \"x\" is given twice"},
    {"PropertyOfNothing", header("ascii", "property float x\n"),
     "m.ply:4:1: this property belongs to no element; a line \"element …\" must come before it"},
    {"OddType", header("ascii", "element vertex 0\nproperty flaot x\n"),
     "m.ply:5:10: \"flaot\" is not a type; did you mean \"float\"?; known are char, uchar, short, ushort, int, uint, "
     "float, "
     "double, int8, uint8, int16, uint16, int32, uint32, float32, float64"},
    {"CountedByFloats", header("ascii", "element face 0\nproperty list float int vertex_index\n"),
     "m.ply:5:15: a list counts its items by an integer type"},
    {"NoVertices", header("ascii", "element face 0\n" + kFaces),
     "m.ply: the file has no element \"vertex\" and so no surface"},
    {"NoZ", header("ascii", "element vertex 0\nproperty float x\nproperty float y\n"),
     "m.ply:4:16: the vertices lack a coordinate; they need the properties x, y and z"},
    {"NoCorners", header("ascii", "element vertex 0\n" + kXyz + "element face 0\nproperty int vertex_index\n"),
     "m.ply:8:14: the faces lack their corners; they need a list \"vertex_indices\""},
    {"NotANumber", ascii("3\n" + kXyz, "1\n" + kFaces, "0 0 0\n1 x 0\n"),
     "m.ply:12:3: \"x\" is not a number; write it like 1.5 or -2e3"},
    {"NotAnInteger", ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "3 0 1.5 2\n"),
     "m.ply:14:5: \"1.5\" is not an integer; write it like 640"},
    {"DoesNotFit", ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "256 0 1 2\n"),
     "m.ply:14:1: 256 does not fit the type that the header gives: 0 … 255"},
    {"IndexTooLarge", ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "3 0 1 3\n"),
     "m.ply:14:7: a face has vertex 3; the file has 3"},
    {"IndexNegative", ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "3 0 1 -1\n"),
     "m.ply:14:7: a face has vertex -1; the file has 3"},
    {"IndexTooLargeBeforeTheVertices",
     header("ascii", "element face 1\n" + kFaces + "element vertex 3\n" + kXyz) + "3 0 1 3\n" + kThree,
     "m.ply: a face has vertex 3; the file has 3"},
    {"IndexOfNothingBeforeTheVertices",
     header("ascii", "element face 1\n" + kFaces + "element vertex 3\n" + kXyz) + "4 0 1 2 3\n" + kThree,
     "m.ply: a face has vertex 3; the file has 3"},
    {"NanUsed", ascii("3\n" + kXyz, "1\n" + kFaces, "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n"),
     "m.ply: vertex 0 is at 0 0 nan; coordinates up to 1000000000 are supported"},
    {"NanInAPolygon", ascii("4\n" + kXyz, "1\n" + kFaces, "0 0 nan\n1 0 0\n0 1 0\n1 1 1\n4 0 1 2 3\n"),
     "m.ply: vertex 0 is at 0 0 nan; coordinates up to 1000000000 are supported"},
    {"NanColor",
     ascii("3\n" + kXyz + "property float red\nproperty float green\nproperty float blue\n", "1\n" + kFaces,
           "0 0 0 1 1 1\n1 0 0 1 nan 1\n0 1 0 1 1 1\n3 0 1 2\n"),
     "m.ply: vertex 1 has the colour 1 nan 1; it must be finite"},
    {"TruncatedAscii", ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "3 0 1"),
     "m.ply: the file ends after 198 bytes, earlier than its header announces"},
    {"TruncatedBinary", binary("element vertex 2\n" + kXyz, std::string(23, '\0')),
     "m.ply: the file ends after 159 bytes, earlier than its header announces"},
    {"TruncatedUnknown",
     binary("element stuff 9999999999999999\nproperty double d\nelement vertex 0\n" + kXyz, "12345678"),
     "m.ply: the file ends after 193 bytes, earlier than its header announces"},
    {"HugeList",
     binary("element vertex 0\nproperty list uint double l\n" + kXyz + "element face 1\n" + kFaces, "\xff\xff\xff\xff"),
     "m.ply: the file ends after 222 bytes, earlier than its header announces"},
    {"HugeFace",
     binary("element vertex 0\n" + kXyz + "element face 1\nproperty list uint int vertex_index\n", "\xff\xff\xff\xff"),
     "m.ply: a face has 4294967295 corners; at most 65536 are supported: triangulate it (byte 187)"},
    {"NegativeList",
     binary("element vertex 0\n" + kXyz + "element face 1\nproperty list char int vertex_index\n", "\xff"),
     "m.ply: the list \"vertex_index\" has -1 items (byte 187)"},
    {"LongNumber", ascii("1\n" + kXyz, "0\n" + kFaces, std::string(5000, '1')),
     "m.ply:11:1: a number of more than 256 characters"},
};
INSTANTIATE_TEST_SUITE_P(Ply, BadPlyFile, ::testing::ValuesIn(kBadPly),
                         [](const auto& bad) { return std::string(bad.param.what); });

TEST(Ply, MemoryIsSpentForWhatTheFileHolds) {
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  const std::string counts = "element vertex 33554432\n" + kXyz + "element face 33554432\n" + kFaces;
  EXPECT_FALSE(read(binary(counts, std::string(100, '\0'))).mesh);
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 16 << 10) << "KiB";
}

TEST(Ply, IsOneOfTheMeshesOfAScene) {
  TemporaryFolder folder;
  folder.write("a.ply", ascii("3\n" + kXyz, "1\n" + kFaces, kThree + "3 0 1 2\n"));
  const Scene scene = read_scene(
      folder.write("s.xml", scene_around("<mesh type='ply'><string name='filename' value='a.ply'/></mesh>")));
  EXPECT_EQ(scene.instances.at(0).name, "a.ply");
  EXPECT_EQ(std::get<TriangleMesh>(scene.shapes.at(0)).triangles.size(), 1u);
}

}  // namespace
}  // namespace etendue::testing
