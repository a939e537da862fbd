/// Warnings about assets that break the standard and are shown all the same.

#include <limits>

#include "gltf_files.h"

namespace etendue::testing {
namespace {

/// A triangle with further members of its node, mesh, primitive and document.
struct Parts {
  std::string node, mesh, primitive, attributes, document;
};

std::string asset(const Parts& parts, GltfBuffer buffer = {}) {
  const int positions = buffer.accessor(right_triangle(), "VEC3", 3);
  const std::string json = document(fmt::format(
      R"("scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{}}}],"meshes":[{{"primitives":[{{"attributes":)"
      R"({{"POSITION":{}{}}}{}}}]{}}}],{}{})",
      parts.node, positions, parts.attributes, parts.primitive, parts.mesh, buffer.json(), parts.document));
  return glb(json, buffer.bytes());
}

/// What reading says besides that there is no camera and no lamp.
std::string said(const std::string& bytes) {
  const GltfRead read = read_asset(bytes);
  EXPECT_TRUE(read.scene.has_value()) << read.messages();
  std::string text;
  for (const Diagnostic& d : read.diagnostics.list()) {
    const bool usual =
        d.message.find("no camera") != std::string::npos || d.message.find("no lamps") != std::string::npos;
    if (!usual) text += d.message + "\n";
  }
  return text;
}

void expect_warning(const Parts& parts, const std::string& sentence, const GltfBuffer& buffer = {}) {
  const std::string text = said(asset(parts, buffer));
  EXPECT_EQ(text, sentence + "\n");
}

/// A material with those members on the triangle.
Parts with_material(const std::string& members) {
  return {.primitive = R"(,"material":0)", .document = R"(,"materials":[{)" + members + "}]"};
}

TEST(GltfAudit, NothingIsSaidOfWhatIsRight) {
  EXPECT_EQ(said(asset({})), "");
  EXPECT_EQ(
      said(asset(with_material(
          R"("name":"m","alphaCutoff":0,"pbrMetallicRoughness":{"metallicFactor":1,"baseColorFactor":[0,0.5,1,1]})"))),
      "");
  EXPECT_EQ(said(asset({.node = R"(,"rotation":[0.7071,0,0,0.7071],"scale":[1,2,3])"})), "");
}

TEST(GltfAudit, Nodes) {
  expect_warning({.node = R"(,"rotation":[0,0,0,0])"}, "the node's rotation has the length 0; the node is not turned");
  expect_warning({.node = R"(,"rotation":[0,0,0,3])"},
                 "the node's rotation has the length 3 instead of 1; it is scaled to it");
  expect_warning({.node = R"(,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],"scale":[1,1,1])"},
                 R"(the node has a "matrix" and a "scale"; the matrix is used)");
  expect_warning({.node = R"(,"weights":[0.5])"},
                 "there are 1 weights for 0 morph targets; those without a weight stay at 0");
  expect_warning({.document = R"(,"skins":[{"joints":[0],"skeleton":9}])"},
                 R"("skeleton" refers to number 9 of "nodes", of which there are 1; it is ignored)");
}

TEST(GltfAudit, Scenes) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  const std::string text =
      said(glb(document(R"("scenes":[{"nodes":[0,0,1],"name":4}],"nodes":[{"children":[1]},{"mesh":0}],)"
                        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)" +
                        buffer.json()),
               buffer.bytes()));
  EXPECT_EQ(text,
            "\"name\" is a number; it must be a string\n"
            "the scene lists node 0 twice; it shows it once\n"
            "node 1 of the scene is no root but a child of node 0; it is shown once\n");
}

TEST(GltfAudit, SceneThatDoesNotExist) {
  const GltfRead read = read_asset("{\"asset\":{\"version\":\"2.0\"},\n \"scene\":3}");
  EXPECT_FALSE(read.scene);
  EXPECT_NE(read.messages().find("a.gltf:2:1"), std::string::npos) << read.messages();
  EXPECT_NE(read.messages().find("number 3 of \"scenes\", of which there are 0"), std::string::npos);
}

TEST(GltfAudit, Attributes) {
  GltfBuffer buffer;
  buffer.accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC2", 2);
  expect_warning({.attributes = R"(,"FOO":0)"},
                 "the attribute \"FOO\" is unknown and is ignored; names of an application begin with \"_\"", buffer);
  expect_warning({.attributes = R"(,"TEXCOORD_2":0)"}, "TEXCOORD_2 comes without TEXCOORD_1; it is not used", buffer);
  GltfBuffer joints;
  joints.accessor(std::vector<std::uint8_t>(12), "VEC4", 4);
  expect_warning({.attributes = R"(,"JOINTS_0":0)"}, "JOINTS_0 comes without WEIGHTS_0; it moves nothing", joints);
  GltfBuffer shorts;
  shorts.accessor(std::vector<std::uint16_t>{0, 0, 1, 0, 0, 1}, "VEC2", 2);
  expect_warning({.attributes = R"(,"TEXCOORD_0":0)"},
                 "TEXCOORD_0 has the component type 5123, which the standard does not allow without "
                 "KHR_mesh_quantization; it is read all the same",
                 shorts);
  EXPECT_EQ(
      said(asset({.attributes = R"(,"TEXCOORD_0":0)", .document = R"(,"extensionsUsed":["KHR_mesh_quantization"])"},
                 shorts)),
      "");
}

TEST(GltfAudit, Materials) {
  expect_warning(with_material(R"("pbrMetallicRoughness":{"metallicFactor":3})"),
                 R"("metallicFactor" is 3; it must be between 0 and 1; the nearest of these is used)");
  expect_warning(with_material(R"("pbrMetallicRoughness":{"baseColorFactor":[1,2,-1,1]})"),
                 R"("baseColorFactor" is 2; it must be between 0 and 1; the nearest of these is used)");
  expect_warning(with_material(R"("emissiveFactor":[0,0,-1])"),
                 R"("emissiveFactor" is -1; it must be at least 0; the nearest of these is used)");
  const auto with_extension = [](const std::string& name, const std::string& members) {
    Parts parts = with_material(R"("extensions":{")" + name + R"(":{)" + members + "}}");
    parts.document += R"(,"extensionsUsed":[")" + name + R"("])";
    return parts;
  };
  expect_warning(with_extension("KHR_materials_ior", R"("ior":0.5)"),
                 R"("ior" is 0.5; it must be 0 or at least 1; 1 is used)");
  EXPECT_EQ(said(asset(with_extension("KHR_materials_ior", R"("ior":0)"))), "");
  expect_warning(with_extension("KHR_materials_clearcoat", R"("clearcoatFactor":7)"),
                 R"("clearcoatFactor" is 7; it must be between 0 and 1; the nearest of these is used)");
  expect_warning(with_extension("KHR_materials_volume", R"("thicknessFactor":1,"attenuationDistance":0)"),
                 R"("attenuationDistance" is 0; it must be above 0; the volume is clear)");
}

TEST(GltfAudit, Extensions) {
  expect_warning(with_material(R"("extensions":{"KHR_materials_unlit":{}})"),
                 R"(the extension "KHR_materials_unlit" is not among "extensionsUsed")");
  expect_warning({.document = R"(,"extensionsRequired":["KHR_texture_transform"])"},
                 R"(the extension "KHR_texture_transform" is required but not among "extensionsUsed")");
  expect_warning({.document = R"(,"extensions":[])"}, R"("extensions" is an array; it must be an object)");
  EXPECT_EQ(said(asset({.document = R"(,"extras":{"extensions":{"FOO":1}})"})), "");
}

TEST(GltfAudit, CamerasSamplersAnimations) {
  expect_warning(
      {.node = R"(,"camera":0)",
       .document = R"(,"cameras":[{"type":"perspective","perspective":{"yfov":1,"aspectRatio":-2,"znear":1}}])"},
      R"("aspectRatio" is -2; it must be above 0 and is ignored)");
  expect_warning(
      {.node = R"(,"camera":0)", .document = R"(,"cameras":[{"type":"perspective","perspective":{"yfov":1}}])"},
      R"(the camera has no "znear" above 0; nothing is cut off in front of it)");
  expect_warning({.document = R"(,"samplers":[{"magFilter":5,"minFilter":9987}])"},
                 R"("magFilter" is 5; it must be 9728 or 9729; 9729 is used)");
  const std::string text =
      said(asset({.document = R"(,"animations":[{"samplers":[{"input":0,"output":7}],)"
                              R"("channels":[{"sampler":1,"target":{"node":5,"path":"scale"}}]}])"}));
  for (const char* part : {R"("output" refers to number 7 of "accessors")",
                           R"("sampler" refers to number 1 of "samplers")", R"("node" refers to number 5 of "nodes")"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(GltfAudit, NumbersOfVertices) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  GltfBuffer colors;
  colors.accessor(std::vector<float>{0, 0, 1.5f, 0, 0, 1, -1, kNaN, 0}, "VEC3", 3);
  expect_warning({.attributes = R"(,"COLOR_0":0)"},
                 "3 of 9 numbers of vertex colours are not between 0 and 1; the nearest of these is used", colors);
  GltfBuffer skin;
  skin.accessor(std::vector<std::uint8_t>(12), "VEC4", 4);
  skin.accessor(std::vector<float>{1, 0, 0, 0, 0, 0, 0, 0, kNaN, 0, 0, 0}, "VEC4", 4);
  expect_warning({.node = R"(,"skin":0)",
                  .attributes = R"(,"JOINTS_0":0,"WEIGHTS_0":1)",
                  .document = R"(,"skins":[{"joints":[0]}])"},
                 "2 of 3 vertices have no weight above 0; the skin does not move them", skin);
}

/// A picture that two textures name is missed once.
TEST(GltfAudit, OneErrorForOnePicture) {
  GltfBuffer buffer;
  buffer.accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC2", 2);
  Parts parts = with_material(
      R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}},"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0})");
  parts.attributes = R"(,"TEXCOORD_0":0)";
  parts.document += R"(,"textures":[{"source":0}],"images":[{"name":"x"}])";
  const GltfRead read = read_asset(asset(parts, buffer));
  EXPECT_FALSE(read.scene);
  EXPECT_EQ(read.diagnostics.error_count(), 1u) << read.messages();
  EXPECT_NE(read.messages().find("neither a \"uri\" nor a \"bufferView\""), std::string::npos) << read.messages();
}

}  // namespace
}  // namespace etendue::testing
