/// Compressed meshes of glTF assets, packed by the libraries that unpack them.

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include "gltf_files.h"

namespace etendue::testing {
namespace {

std::vector<std::uint8_t> packed_vertices(const std::vector<float>& numbers) {
  const std::size_t count = numbers.size() / 3;
  std::vector<std::uint8_t> bytes(meshopt_encodeVertexBufferBound(count, 12));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), numbers.data(), count, 12));
  return bytes;
}

/// An asset of a square whose positions and indices are packed; `count` is what is said of the positions.
GltfRead packed_square(std::vector<std::uint8_t> vertices, std::size_t count = 4, const char* mode = "ATTRIBUTES",
                       const std::string& more = "") {
  const std::vector<std::uint32_t> corners = {0, 1, 2, 2, 1, 3};
  std::vector<std::uint8_t> triangles(meshopt_encodeIndexBufferBound(6, 4));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), corners.data(), 6));
  const auto extension = [](std::size_t size, std::size_t n, int stride, const char* what) {
    return fmt::format(
        R"(,"extensions":{{"EXT_meshopt_compression":{{"buffer":0,"byteOffset":0,"byteLength":{},"byteStride":{},"count":{},"mode":"{}"}}}})",
        size, stride, n, what);
  };
  GltfBuffer buffer;
  std::string first = extension(vertices.size(), count, 12, mode);
  first.insert(first.size() - 2, more);
  buffer.view(vertices, first);
  std::string second = extension(triangles.size(), 6, 4, "TRIANGLES");
  const std::size_t offset = (vertices.size() + 3) / 4 * 4;
  second.replace(second.find("\"byteOffset\":0"), 14, fmt::format("\"byteOffset\":{}", offset));
  buffer.view(triangles, second);
  buffer.add_accessor(R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")");
  buffer.add_accessor(R"("bufferView":1,"componentType":5125,"count":6,"type":"SCALAR")");
  return read_asset(glb(one_primitive(buffer, R"("attributes":{"POSITION":0},"indices":1)"), buffer.bytes()));
}

TEST(GltfCompression, Meshopt) {
  const std::vector<float> square = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.25f};
  const GltfRead read = packed_square(packed_vertices(square));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(read.mesh().positions.at(3), glm::dvec3(1, 1, 0.25));
  EXPECT_EQ(read.mesh().triangles.size(), 2u);
  std::vector<std::uint8_t> damaged = packed_vertices(square);
  damaged[0] = 0;
  EXPECT_NE(packed_square(damaged).messages().find("stream is damaged"), std::string::npos);
  damaged[0] = 0xaf;
  EXPECT_NE(packed_square(damaged).messages().find("has the version 15 of its codec"), std::string::npos);
  EXPECT_NE(packed_square(packed_vertices(square), 1u << 30).messages().find("cannot hold"), std::string::npos);
  const GltfRead colors = packed_square(packed_vertices(square), 4, "ATTRIBUTES", R"(,"filter":"COLOR")");
  EXPECT_NE(colors.messages().find("the filter \"COLOR\" of the compression is not among those"), std::string::npos);
  EXPECT_NE(packed_square(packed_vertices(square), 4, "MAGIC").messages().find("mode \"MAGIC\""), std::string::npos);
}

std::vector<std::uint8_t> draco_triangle(int& position_id) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  position_id = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const float a[] = {0, 0, 0}, b[] = {1, 0, 0}, c[] = {0, 1, 0};
  builder.SetAttributeValuesForFace(position_id, draco::FaceIndex(0), a, b, c);
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  position_id = static_cast<int>(mesh->attribute(position_id)->unique_id());
  return {buffer.data(), buffer.data() + buffer.size()};
}

GltfRead draco_asset(const std::vector<std::uint8_t>& packed, int id) {
  GltfBuffer buffer;
  buffer.view(packed);
  buffer.add_accessor(R"("componentType":5126,"count":3,"type":"VEC3")");
  return read_asset(glb(
      one_primitive(
          buffer,
          fmt::format(
              R"("attributes":{{"POSITION":0}},"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{"POSITION":{}}}}}}})",
              id)),
      buffer.bytes()));
}

TEST(GltfCompression, Draco) {
  int id = 0;
  const std::vector<std::uint8_t> packed = draco_triangle(id);
  const GltfRead read = draco_asset(packed, id);
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  double area = 0.0;
  for (const glm::uvec3& t : read.mesh().triangles) {
    const auto& p = read.mesh().positions;
    area += 0.5 * glm::length(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]));
  }
  EXPECT_NEAR(area, 0.5, 1e-3);
  EXPECT_NE(draco_asset(packed, id + 9).messages().find("no attribute for \"POSITION\""), std::string::npos);
  for (std::size_t size = 0; size < packed.size(); ++size) {
    const GltfRead cut = draco_asset({packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size)}, id);
    EXPECT_EQ(cut.scene.has_value(), !cut.diagnostics.has_errors()) << size;
  }
}

}  // namespace
}  // namespace etendue::testing
