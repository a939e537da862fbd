/// Geometry of glTF assets: containers, accessors, primitives, nodes.

#include "formats/gltf/accessors.h"
#include "gltf_files.h"

namespace etendue::testing {
namespace {

TEST(GltfGeometry, ATriangleOfABinaryFile) {
  GltfBuffer buffer;
  const int positions = buffer.accessor(right_triangle(), "VEC3", 3);
  const int indices = buffer.accessor(std::vector<std::uint16_t>{0, 1, 2}, "SCALAR", 1);
  const GltfRead read = read_asset(
      glb(one_primitive(buffer, fmt::format(R"("attributes":{{"POSITION":{}}},"indices":{})", positions, indices)),
          buffer.bytes()));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(read.mesh().positions.at(1), glm::dvec3(1, 0, 0));
  EXPECT_EQ(read.mesh().triangles, std::vector<glm::uvec3>{glm::uvec3(0, 1, 2)});
  EXPECT_TRUE(read.mesh().normals.empty());  // flat
  EXPECT_NE(read.messages().find("no camera"), std::string::npos);
  EXPECT_NE(read.messages().find("no lamps"), std::string::npos);
}

/// The triangles of six vertices in a row.
std::vector<glm::uvec3> triangles_of_mode(int mode) {
  GltfBuffer buffer;
  std::vector<float> positions;
  for (int i = 0; i < 6; ++i)
    positions.insert(positions.end(), {static_cast<float>(i / 2), static_cast<float>(i % 2), 0});
  const int index = buffer.accessor(positions, "VEC3", 3);
  const GltfRead read = read_asset(glb(
      one_primitive(buffer, fmt::format(R"("attributes":{{"POSITION":{}}},"mode":{})", index, mode)), buffer.bytes()));
  return read.scene ? read.mesh().triangles : std::vector<glm::uvec3>{};
}

TEST(GltfGeometry, ListsStripsAndFans) {
  using Triangles = std::vector<glm::uvec3>;
  EXPECT_EQ(triangles_of_mode(4), (Triangles{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(triangles_of_mode(5), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}}));
  EXPECT_EQ(triangles_of_mode(6), (Triangles{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}, {4, 5, 0}}));
  for (const int mode : {0, 1, 2, 3, 7}) EXPECT_TRUE(triangles_of_mode(mode).empty());
}

TEST(GltfGeometry, NormalisedNumbersOfEveryType) {
  GltfBuffer buffer;
  const int positions = buffer.accessor(right_triangle(), "VEC3", 3);
  const int i8 = buffer.accessor(std::vector<std::int8_t>{127, -127, -128, 0}, "SCALAR", 1, R"(,"normalized":true)");
  const int u8 = buffer.accessor(std::vector<std::uint8_t>{255, 51}, "SCALAR", 1, R"(,"normalized":true)");
  const int i16 = buffer.accessor(std::vector<std::int16_t>{32767, -32768}, "SCALAR", 1, R"(,"normalized":true)");
  const int u16 = buffer.accessor(std::vector<std::uint16_t>{65535, 13107}, "SCALAR", 1, R"(,"normalized":true)");
  const int plain = buffer.accessor(std::vector<std::uint32_t>{7}, "SCALAR", 1);
  EXPECT_EQ(positions, 0);
  const std::string text = glb(document(buffer.json()), buffer.bytes());
  std::vector<std::byte> file(text.size());
  std::memcpy(file.data(), text.data(), file.size());
  GltfDocument asset("a.glb", memory_store(file), {});
  Accessors accessors(asset);
  const auto floats = [&](int index) {
    return accessors.floats(static_cast<std::uint32_t>(index), asset.root(), {1}).numbers;
  };
  EXPECT_EQ(floats(i8), (std::vector<float>{1, -1, -1, 0}));
  EXPECT_EQ(floats(u8), (std::vector<float>{1, 0.2f}));
  EXPECT_EQ(floats(i16), (std::vector<float>{1, -1}));
  EXPECT_EQ(floats(u16), (std::vector<float>{1, 0.2f}));
  EXPECT_EQ(floats(plain), (std::vector<float>{7}));
}

TEST(GltfGeometry, SparseRowsAndInterleavedOnes) {
  GltfBuffer buffer;
  // Position and normal in turn, 24 bytes a vertex.
  const int both =
      buffer.view(std::vector<float>{0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 2, 0, 1, 0, 0, 0, 2}, R"(,"byteStride":24)");
  const int places = buffer.view(std::vector<std::uint8_t>{2});
  const int values = buffer.view(std::vector<float>{0, 5, 0});
  const int positions = buffer.add_accessor(fmt::format(
      R"("bufferView":{},"componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":1,"indices":{{"bufferView":{},"componentType":5121}},"values":{{"bufferView":{}}}}})",
      both, places, values));
  const int normals = buffer.add_accessor(
      fmt::format(R"("bufferView":{},"byteOffset":12,"componentType":5126,"count":3,"type":"VEC3")", both));
  const GltfRead read = read_asset(
      glb(one_primitive(buffer, fmt::format(R"("attributes":{{"POSITION":{},"NORMAL":{}}})", positions, normals)),
          buffer.bytes()));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(read.mesh().positions, (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 5, 0}}));
  EXPECT_EQ(read.mesh().normals.at(2), glm::dvec3(0, 0, 1));  // of length 1
}

TEST(GltfGeometry, PositionsAndNormalsTakeNoMoreMemoryThanInTheFile) {
  GltfBuffer buffer;
  const int positions = buffer.accessor(std::vector<float>{0.1f, 0, 0, 1, 1e-7f, 0, 0, 1, 0.3f}, "VEC3", 3);
  const int normals = buffer.accessor(std::vector<float>{0, 0, 2, 0, 0.3f, 0.9f, 0.5f, 0.6f, 0.7f}, "VEC3", 3);
  const GltfRead read = read_asset(
      glb(one_primitive(buffer, fmt::format(R"("attributes":{{"POSITION":{},"NORMAL":{}}})", positions, normals)),
          buffer.bytes()));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const TriangleMesh& mesh = read.mesh();
  EXPECT_EQ(mesh.positions.bytes(), 3 * sizeof(glm::vec3));
  EXPECT_EQ(mesh.normals.bytes(), 3 * sizeof(glm::vec3));
  EXPECT_EQ(mesh.positions, (std::vector<glm::dvec3>{{0.1f, 0, 0}, {1, 1e-7f, 0}, {0, 1, 0.3f}}));
  for (const glm::dvec3& n : mesh.normals) EXPECT_NEAR(glm::length(n), 1.0, 1e-7);
}

/// What is said of a triangle whose accessor has those members.
std::string complaint(const std::string& accessor, const std::string& view_more = "") {
  GltfBuffer buffer;
  buffer.view(right_triangle(), view_more);
  buffer.add_accessor(accessor);
  const GltfRead read = read_asset(glb(one_primitive(buffer, R"("attributes":{"POSITION":0})"), buffer.bytes()));
  EXPECT_FALSE(read.scene.has_value());
  return read.messages();
}

TEST(GltfGeometry, RangesAreHeldAgainstTheirBuffers) {
  const auto has = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  const std::string floats = R"(,"componentType":5126,"type":"VEC3")";
  has(complaint(R"("bufferView":0,"count":4)" + floats),
      "4 rows of 12 bytes with a stride of 12, starting at byte 0, exceed");
  has(complaint(R"("bufferView":0,"byteOffset":4,"count":3)" + floats), "exceed their view");
  has(complaint(R"("bufferView":0,"byteOffset":9007199254740992,"count":3)" + floats), "exceed their view");
  has(complaint(R"("bufferView":0,"count":9007199254740992)" + floats), "rows; at most");
  has(complaint(R"("bufferView":0,"count":3)" + floats, R"(,"byteStride":4)"), "have a stride of 4 bytes");
  has(complaint(R"("bufferView":7,"count":3)" + floats), "number 7 of \"bufferViews\", of which there are 1");
  has(complaint(R"("count":99999999)" + floats), "rows; at most");
  has(complaint(R"("bufferView":0,"count":3,"componentType":5124,"type":"VEC3")"), "component type 5124");
  has(complaint(R"("bufferView":0,"count":3,"componentType":5126,"type":"VEC9")"), "type \"VEC9\"");
  has(complaint(R"("bufferView":0,"count":-3)" + floats), "\"count\" is -3");
  has(complaint(R"("bufferView":"0","count":3)" + floats), "\"bufferView\" is a string");
  has(complaint(R"("bufferView":0,"count":3)" + floats, R"(,"byteLength":37)"), "exceeds its buffer");
}

TEST(GltfGeometry, IndicesThatLeadNowhereAreLeftOut) {
  GltfBuffer buffer;
  const int positions = buffer.accessor(right_triangle(), "VEC3", 3);
  const int indices = buffer.accessor(std::vector<std::uint32_t>{0, 1, 2, 0, 1, 3, 0, 1, 4000000000u}, "SCALAR", 1);
  const GltfRead read = read_asset(
      glb(one_primitive(buffer, fmt::format(R"("attributes":{{"POSITION":{}}},"indices":{})", positions, indices)),
          buffer.bytes()));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(read.mesh().triangles.size(), 1u);
  EXPECT_NE(read.messages().find("2 of 3 triangles refer to vertices that do not exist"), std::string::npos);
}

/// An asset of a triangle with those nodes, of which the first is the root.
GltfRead read_nodes(const std::string& nodes, const ReadOptions& options = {}) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  return read_asset(
      glb(document(fmt::format(
              R"("scenes":[{{"nodes":[0]}},{{"name":"other","nodes":[1]}}],"nodes":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],{})",
              nodes, buffer.json())),
          buffer.bytes()),
      options);
}

TEST(GltfGeometry, NodesStandInEachOther) {
  const GltfRead read = read_nodes(
      R"({"children":[1,2],"translation":[0,0,5],"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,2,2]},)"
      R"({"name":"a","mesh":0,"translation":[1,0,0]},)"
      R"({"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 3,0,0,1]})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  ASSERT_EQ(read.scene->instances.size(), 2u);
  EXPECT_EQ(read.scene->shapes.size(), 1u);  // shared
  const Instance& a = read.scene->instances[0];
  EXPECT_EQ(a.name, "a");
  const glm::dvec3 corner(a.world_from_object * glm::dvec4(1, 0, 0, 1));
  EXPECT_LT(glm::distance(corner, glm::dvec3(0, 4, 5)), 1e-12);
  EXPECT_LT(glm::determinant(glm::dmat3(read.scene->instances[1].world_from_object)), 0.0);
}

TEST(GltfGeometry, ScenesAreChosenByNameOrNumber) {
  const std::string nodes = R"({"mesh":0,"children":[1]},{"mesh":0})";
  EXPECT_EQ(read_nodes(nodes).scene.value().instances.size(), 2u);
  EXPECT_EQ(read_nodes(nodes, {.scene = "other"}).scene.value().instances.size(), 1u);
  EXPECT_EQ(read_nodes(nodes, {.scene = "1"}).scene.value().instances.size(), 1u);
  const GltfRead refused = read_nodes(nodes, {.scene = "third"});
  EXPECT_FALSE(refused.scene.has_value());
  EXPECT_NE(refused.messages().find("--scene third"), std::string::npos);
}

TEST(GltfGeometry, CirclesOfNodesAreRefused) {
  for (const char* nodes :
       {R"({"mesh":0,"children":[0]})", R"({"mesh":0,"children":[1]},{"children":[2]},{"children":[1]})",
        R"({"children":[1,2]},{"children":[2]},{"mesh":0})", R"({"children":[9]})",
        R"({"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2]})", R"({"mesh":3})", R"({})", "7"}) {
    const GltfRead read = read_nodes(nodes);
    EXPECT_FALSE(read.scene.has_value()) << nodes;
    EXPECT_TRUE(read.diagnostics.has_errors()) << nodes;
  }
}

TEST(GltfGeometry, InstancesOfANode) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  const int places = buffer.accessor(std::vector<float>{1, 0, 0, 0, 2, 0}, "VEC3", 3);
  const int scales = buffer.accessor(std::vector<float>{1, 1, 1, 3, 3, 3}, "VEC3", 3);
  const GltfRead read = read_asset(glb(
      document(fmt::format(
          R"("scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"translation":[0,0,7],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{},"SCALE":{}}}}}}}}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],{})",
          places, scales, buffer.json())),
      buffer.bytes()));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  ASSERT_EQ(read.scene->instances.size(), 2u);
  EXPECT_EQ(read.scene->instances[1].world_from_object * glm::dvec4(1, 0, 0, 1), glm::dvec4(3, 2, 7, 1));
}

TEST(GltfGeometry, MorphTargetsAndSkinsAtRest) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  const int offsets = buffer.accessor(std::vector<float>{0, 0, 0, 0, 0, 4, 0, 0, 0}, "VEC3", 3);
  const int joints = buffer.accessor(std::vector<std::uint8_t>{0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4);
  const int weights = buffer.accessor(std::vector<float>{0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
  const GltfRead read = read_asset(glb(
      document(fmt::format(
          R"("scenes":[{{"nodes":[0,1,2]}}],"nodes":[{{"mesh":0,"skin":0,"weights":[0.5],"translation":[9,9,9]}},{{"translation":[0,0,1]}},{{"translation":[0,0,3]}}],"skins":[{{"joints":[1,2]}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"JOINTS_0":{},"WEIGHTS_0":{}}},"targets":[{{"POSITION":{}}}]}}]}}],{})",
          joints, weights, offsets, buffer.json())),
      buffer.bytes()));
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  EXPECT_EQ(read.mesh().positions, (std::vector<glm::dvec3>{{0, 0, 2}, {1, 0, 5}, {0, 1, 1}}));
  EXPECT_EQ(read.scene->instances[0].world_from_object, glm::dmat4(1.0));
}

}  // namespace
}  // namespace etendue::testing
