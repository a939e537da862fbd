// Thousands of damaged copies of sound files: each reads, or is refused with a place and a sentence of one line.

#include "formats/ply/ply_reader.h"

#include <algorithm>
#include "formats_testing.h"
#include "scene/check.h"

namespace etendue::testing {
namespace {

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Copies with one thing wrong each, the same on every machine.
std::vector<std::string> mutations(const std::string& text, std::size_t count) {
  static constexpr std::string_view kInserted[] = {"<",     ">",   "\"", "&",  "/",    "-",
                                                   "1e999", "nan", " ",  "\n", "\xff", "0x"};
  std::vector<std::string> all;
  std::uint32_t state = 12345;
  const auto random = [&](std::size_t below) {
    state = state * 1664525u + 1013904223u;
    return static_cast<std::size_t>((std::uint64_t{state} * below) >> 32);
  };
  for (std::size_t i = 0; i < count; ++i) {
    std::string copy = text;
    const std::size_t at = random(copy.size()), other = random(copy.size());
    switch (i % 6) {
      case 0:
        copy.resize(at);
        break;
      case 1:
        copy[at] = static_cast<char>(random(256));
        break;
      case 2:
        copy.erase(at, 1 + random(20));
        break;
      case 3:
        copy.insert(at, kInserted[random(std::size(kInserted))]);
        break;
      case 4:
        copy.insert(at, text.substr(other, random(60)));
        break;
      default:
        std::swap(copy[at], copy[other]);
    }
    all.push_back(std::move(copy));
  }
  return all;
}

void expect_one_line(const Diagnostic& d, const std::string& file) {
  EXPECT_FALSE(d.message.empty());
  EXPECT_EQ(d.message.find('\n'), std::string::npos) << d.message;
  EXPECT_EQ(d.position.file, file) << d.message;
  const bool whole_file = d.message.find("has no faces") != std::string::npos ||
                          d.message.find("needs things that are not supported") != std::string::npos ||
                          d.severity != Severity::error;
  EXPECT_TRUE(whole_file || (d.position.line > 0 && d.position.column > 0)) << to_string(d);
}

TEST(Mutations, OfScenes) {
  std::size_t refused = 0, read = 0;
  for (const char* name : {"/cbox-sphere.xml", "/ttest-furnace.xml"}) {
    for (const std::string& text : mutations(read_text(SCENES_DIR + std::string(name)), 6000)) {
      const Parsed parsed = parse(text);
      EXPECT_NE(parsed.file.has_value(), parsed.diagnostics.has_errors());
      ++(parsed.file ? read : refused);
      for (const Diagnostic& d : parsed.diagnostics.list()) {
        if (d.position.file == "s.xml") expect_one_line(d, "s.xml");
      }
      if (::testing::Test::HasFailure()) FAIL() << text;
    }
  }
  EXPECT_GT(refused, 4000u);
  EXPECT_GT(read, 500u);
}

TEST(Mutations, OfMeshes) {
  const std::string mesh =
      "# a mesh\nmtllib a.mtl\no a\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0.1e1 +1 -1e-3\nv 0 1 0\nvt 0 0\nvt 1 "
      "0.5 0\n"
      "vn 0 0 1\nvn 0 1 0\ng b\ns off\nusemtl m\nf 1 2 3\nf 1/1 2/2 3/1 5/1\nf 1//1 2//1 3//2\nf -1/-1/-1 -2/1/1 "
      "-3/2/1\n"
      "f 1 2 \\\n 3 4 5\n";
  std::size_t refused = 0, read = 0;
  for (const std::string& text : mutations(mesh, 12000)) {
    Diagnostics diagnostics;
    const auto result = read_obj(memory_source(text), "m.obj", {}, diagnostics);
    EXPECT_NE(result.has_value(), diagnostics.has_errors());
    ++(result ? read : refused);
    for (const Diagnostic& d : diagnostics.list()) expect_one_line(d, "m.obj");
    if (::testing::Test::HasFailure()) FAIL() << text;
  }
  EXPECT_GT(refused, 2000u);
  EXPECT_GT(read, 2000u);
}

TEST(Mutations, OfPlyFiles) {
  const std::string head =
      " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty float u\nproperty float v\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n";
  std::string binary = "ply\nformat binary_little_endian" + head;
  for (int i = 0; i < 4; ++i) {
    const float numbers[] = {static_cast<float>(i % 2), static_cast<float>(i / 2), 0.0f};
    binary.append(reinterpret_cast<const char*>(numbers), sizeof numbers).append("\x01\x80\xff", 3);
    binary.append(reinterpret_cast<const char*>(numbers), 2 * sizeof(float));
  }
  binary += std::string("\x03\0\0\0\0\x01\0\0\0\x02\0\0\0\x04\0\0\0\0\x01\0\0\0\x03\0\0\0\x02\0\0\0", 30);
  const std::string ascii =
      "ply\nformat ascii" + head +
      "0 0 0 1 2 3 0 0\n1 0 0 255 1 1 1 0\n1 1 0 0 0 0 1 1\n0 1 0 9 9 9 0 1\n3 0 1 2\n4 0 1 2 3\n";
  std::size_t refused = 0, read = 0;
  for (const std::string& seed : {ascii, binary}) {
    for (const std::string& text : mutations(seed, 6000)) {
      Diagnostics diagnostics;
      const auto mesh = read_ply(memory_source(text), "m.ply", {}, diagnostics, text.size());
      EXPECT_NE(mesh.has_value(), diagnostics.has_errors());
      ++(mesh ? read : refused);
      for (const Diagnostic& d : diagnostics.list()) EXPECT_EQ(d.message.find('\n'), std::string::npos) << d.message;
      if (!mesh) continue;
      for (const glm::uvec3& t : mesh->triangles) ASSERT_LT(std::max({t.x, t.y, t.z}), mesh->positions.size()) << text;
      for (const glm::dvec3& p : mesh->positions) ASSERT_TRUE(std::abs(p.x + p.y + p.z) < 1e10) << text;
    }
  }
  EXPECT_GT(refused, 2000u);
  EXPECT_GT(read, 1000u);
}

}  // namespace
}  // namespace etendue::testing
