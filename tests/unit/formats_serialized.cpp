// Mitsuba's .serialized files, made by zlib in memory.

#include <cstring>

#include <gtest/gtest.h>
#include <zlib.h>

#include "formats/serialized/serialized_reader.h"

namespace etendue::testing {
namespace {

using Bytes = std::vector<std::byte>;

template <typename T>
void put(Bytes& bytes, const T& value) {
  const auto* begin = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof(T));
}

/// A mesh of one triangle with normals and texture coordinates, in float or double.
template <typename Real>
Bytes make_mesh(std::uint16_t version, std::uint32_t flags, std::uint32_t last_index = 2,
                std::uint64_t announced_vertices = 3) {
  Bytes body;
  put(body, flags | (sizeof(Real) == 8 ? 0x2000u : 0x1000u));
  if (version == 4) {
    put(body, 'm');
    put(body, '\0');
  }
  put(body, announced_vertices);
  put(body, std::uint64_t{1});
  for (const int x : {0, 0, 0, 1, 0, 0, 0, 2, 0}) put(body, static_cast<Real>(x));
  if ((flags & 1) != 0)
    for (const int x : {0, 0, 3, 0, 0, 1, 0, 0, 0}) put(body, static_cast<Real>(x));
  if ((flags & 2) != 0)
    for (const Real x : {Real(0), Real(0), Real(1), Real(0), Real(0), Real(0.5)}) put(body, x);
  if ((flags & 8) != 0)
    for (int i = 0; i < 9; ++i) put(body, Real(0.25));
  for (const std::uint32_t i : {0u, 1u, last_index}) put(body, i);
  uLongf size = compressBound(body.size());
  Bytes packed(size);
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(body.data()), body.size());
  Bytes mesh;
  put(mesh, std::uint16_t{0x041c});
  put(mesh, version);
  mesh.insert(mesh.end(), packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
  return mesh;
}

Bytes make_file(const std::vector<Bytes>& meshes, std::uint16_t version = 4) {
  Bytes file;
  std::vector<std::uint64_t> offsets;
  for (const Bytes& mesh : meshes) {
    offsets.push_back(file.size());
    file.insert(file.end(), mesh.begin(), mesh.end());
  }
  for (const std::uint64_t offset : offsets) {
    if (version == 4) put(file, offset);
    if (version == 3) put(file, static_cast<std::uint32_t>(offset));
  }
  put(file, static_cast<std::uint32_t>(meshes.size()));
  return file;
}

std::string error_of(const Bytes& file, std::int64_t index = 0) {
  Diagnostics diagnostics;
  EXPECT_FALSE(read_serialized(file, "m.serialized", index, diagnostics).has_value());
  return diagnostics.list().empty() ? "" : to_string(diagnostics.list().front());
}

TEST(Serialized, ReadsWhatAMeshHas) {
  const Bytes file = make_file({make_mesh<float>(4, 0), make_mesh<double>(4, 1 | 2 | 8 | 0x10)});
  Diagnostics diagnostics;
  const auto plain = read_serialized(file, "m.serialized", 0, diagnostics);
  ASSERT_TRUE(plain.has_value());
  EXPECT_EQ(plain->mesh.positions, (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}}));
  EXPECT_EQ(plain->mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
  EXPECT_TRUE(plain->mesh.normals.empty());
  EXPECT_FALSE(plain->face_normals);
  const auto full = read_serialized(file, "m.serialized", 1, diagnostics);
  ASSERT_TRUE(full.has_value());
  EXPECT_EQ(full->mesh.normals, (std::vector<glm::dvec3>{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}));
  ASSERT_EQ(full->mesh.uv_sets.size(), 1u);
  EXPECT_EQ(full->mesh.uv_sets[0][2], glm::vec2(0, 0.5f));
  EXPECT_EQ(full->mesh.vertex_colors.at(1), glm::vec3(0.25f));
  EXPECT_TRUE(full->face_normals);
}

TEST(Serialized, ReadsVersionThree) {
  const Bytes file = make_file({make_mesh<float>(3, 0), make_mesh<float>(3, 1)}, 3);
  Diagnostics diagnostics;
  const auto mesh = read_serialized(file, "m.serialized", 1, diagnostics);
  ASSERT_TRUE(mesh.has_value()) << to_string(diagnostics.list().front());
  EXPECT_EQ(mesh->mesh.normals.size(), 3u);
}

TEST(Serialized, SaysWhatIsWrong) {
  const Bytes good = make_file({make_mesh<float>(4, 0)});
  EXPECT_NE(error_of(good, 1).find("the file has 1 meshes; there is no number 1"), std::string::npos);
  EXPECT_NE(error_of({}).find("no .serialized file"), std::string::npos);
  EXPECT_NE(error_of(make_file({make_mesh<float>(4, 0, 3)})).find("triangle 0 has the vertex 3, of which there are 3"),
            std::string::npos);
  EXPECT_NE(error_of(make_file({make_mesh<float>(4, 0, 2, 4)})).find("is the file complete?"), std::string::npos);
  EXPECT_NE(error_of(make_file({make_mesh<float>(4, 0, 2, std::uint64_t{1} << 40)})).find("1099511627776 vertices"),
            std::string::npos);
  Bytes damaged = good;
  damaged[8] = std::byte{0xff};
  EXPECT_NE(error_of(damaged), "");
  // Cut anywhere, it is refused and nothing else.
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(error_of(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))), "") << size;
}

}  // namespace
}  // namespace etendue::testing
