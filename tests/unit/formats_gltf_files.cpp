/// What a glTF asset may open and how its files are put together.

#include <filesystem>

#include "formats/gltf/uri.h"
#include "gltf_files.h"

namespace etendue::testing {
namespace {

/// The asset of a triangle whose buffer is at a URI.
std::string triangle_at(const std::string& uri) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  return document(fmt::format(
      R"("scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],{})",
      buffer.json(uri)));
}

std::string triangle_bytes() {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  return buffer.bytes();
}

/// What reading an asset with that URI says; "" where it works.
std::string read_with(const TemporaryFolder& folder, const std::string& uri) {
  Diagnostics diagnostics;
  const auto scene = read_gltf(folder.write("in/a.gltf", triangle_at(uri)), {}, diagnostics);
  EXPECT_EQ(scene.has_value(), !diagnostics.has_errors());
  return scene ? "" : all_messages(diagnostics);
}

TEST(GltfFiles, BuffersBesideTheAsset) {
  const TemporaryFolder folder;
  folder.write("in/b.bin", triangle_bytes());
  folder.write("in/sub/a b.bin", triangle_bytes());
  EXPECT_EQ(read_with(folder, "b.bin"), "");
  EXPECT_EQ(read_with(folder, "./sub/../b.bin"), "");
  EXPECT_EQ(read_with(folder, "sub/a%20b.bin"), "");
  EXPECT_EQ(read_with(folder, "sub/a b.bin"), "");
  EXPECT_EQ(read_with(folder, "sub\\\\a b.bin"), "");
  EXPECT_EQ(read_with(folder, "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"),
            "");
}

TEST(GltfFiles, NothingOutsideTheFolderIsOpened) {
  const TemporaryFolder folder;
  folder.write("b.bin", triangle_bytes());
  folder.write("in/c.bin", triangle_bytes());
  const auto refuses = [&](const std::string& uri, const char* why) {
    EXPECT_NE(read_with(folder, uri).find(why), std::string::npos) << uri << ": " << read_with(folder, uri);
  };
  refuses("../b.bin", "outside the folder");
  refuses("c.bin/../../b.bin", "outside the folder");
  refuses("%2e%2e/b.bin", "outside the folder");
  refuses(folder.path("in/c.bin"), "absolute paths are not followed");
  refuses("file:c.bin", "only files next to the model");
  refuses("https://example.org/c.bin", "only files next to the model");
  refuses("etendue:bust.obj", "only files next to the model");
  refuses("c%00.bin", "zero byte");
  refuses("none.bin", "cannot open the file");
  refuses("sub", "cannot open the file");
  std::filesystem::create_symlink("../b.bin", folder.path("in/link.bin"));
  std::filesystem::create_symlink("c.bin", folder.path("in/inside.bin"));
  refuses("link.bin", "outside the folder");
  EXPECT_EQ(read_with(folder, "inside.bin"), "");
  std::filesystem::create_directory(folder.path("in/folder"));
  refuses("folder", "a folder");
}

TEST(GltfFiles, DataUris) {
  const auto text = [](std::string_view uri) {
    const DataUri data = parse_data_uri(uri).value();
    return std::string(reinterpret_cast<const char*>(data.bytes.data()), data.bytes.size());
  };
  EXPECT_EQ(text("data:;base64,aGVsbG8="), "hello");
  EXPECT_EQ(text("data:text/plain;base64,aGVsbG8h"), "hello!");
  EXPECT_EQ(text("data:,a%20b"), "a b");
  EXPECT_FALSE(parse_data_uri("data.bin").has_value());
  for (const char* wrong : {"data:base64", "data:;base64,a", "data:;base64,a*bc"})
    EXPECT_THROW(text(wrong), UriError) << wrong;
}

TEST(GltfFiles, DamagedContainers) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  const std::string whole = glb(one_primitive(buffer, R"("attributes":{"POSITION":0})"), buffer.bytes());
  ASSERT_TRUE(read_asset(whole).scene.has_value());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const GltfRead read = read_asset(whole.substr(0, size));
    EXPECT_FALSE(read.scene.has_value()) << size;
    EXPECT_TRUE(read.diagnostics.has_errors()) << size;
  }
  for (std::size_t at = 4; at < 20; ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(0xff);
    read_asset(changed);  // an error or not, but no fault
  }
}

TEST(GltfFiles, WhatIsNoGltf2) {
  const auto says = [](const std::string& text, const char* part) {
    const GltfRead read = read_asset(text);
    EXPECT_FALSE(read.scene.has_value());
    EXPECT_NE(read.messages().find(part), std::string::npos) << read.messages();
  };
  says("", "this is not JSON");
  says("{\n \"asset\": {\"version\": \"2.0\"}, \n  x}", "a.gltf:3:3: this is not JSON from here on");
  says("[]", "the document is an array");
  says("{}", "has no \"asset\"");
  says(R"({"asset":{"version":"1.0"}})", "this is glTF \"1.0\"");
  says(R"({"asset":{"version":"2.0","minVersion":"2.7"}})", "needs glTF \"2.7\"");
  says(R"({"asset":{"version":2}})", "\"version\" is a number");
  says(std::string(200, '[') + std::string(200, ']'), "arrays and objects are nested more than");
  says(document(R"("extensionsRequired":["ACME_magic"],"extensionsUsed":["ACME_magic"])"),
       "requires the extension \"ACME_magic\"");
  says(document(R"("scenes":[{"nodes":[]}])"), "no triangles");
  says(document(R"("nodes":3)"), "\"nodes\" is a number");
}

TEST(GltfFiles, UnknownExtensionsInUseAreAWarning) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  const GltfRead read = read_asset(glb(one_primitive(buffer, R"("attributes":{"POSITION":0})",
                                                     R"(,"extensionsUsed":["ACME_magic","KHR_materials_ior"])"),
                                       buffer.bytes()));
  EXPECT_TRUE(read.scene.has_value());
  EXPECT_NE(read.messages().find("uses the extension \"ACME_magic\""), std::string::npos);
  EXPECT_EQ(read.messages().find("KHR_materials_ior"), std::string::npos);
}

}  // namespace
}  // namespace etendue::testing
