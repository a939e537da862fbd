/// Warnings about assets that break the standard and are shown all the same.

#include <ctime>
#include <limits>

#include "gltf_files.h"

namespace etendue::testing {
namespace {

constexpr const char* kBounds = R"(,"min":[0,0,0],"max":[1,1,0])";  // of the triangle

/// A triangle with further members of its node, mesh, primitive and document.
struct Parts {
  std::string node, mesh, primitive, attributes, document;
};

std::string asset(const Parts& parts, GltfBuffer buffer = {}) {
  const int positions = buffer.accessor(right_triangle(), "VEC3", 3, kBounds);
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

/// Expects a warning that contains `part`.
void expect_said(const Parts& parts, const std::string& part, const GltfBuffer& buffer = {}) {
  const std::string text = said(asset(parts, buffer));
  EXPECT_NE(text.find(part), std::string::npos) << "missing: " << part << "\nsaid: " << text;
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
          R"("name":"m","alphaMode":"MASK","alphaCutoff":0,"pbrMetallicRoughness":{"metallicFactor":1,"baseColorFactor":[0,0.5,1,1]})"))),
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
  buffer.accessor(right_triangle(), "VEC3", 3, kBounds);
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
  expect_warning({.attributes = R"(,"JOINTS_0":0)"},
                 "JOINTS_0 comes without WEIGHTS_0; it moves nothing\n"
                 "the node shows a mesh with JOINTS_0 but has no \"skin\"; the mesh keeps its shape",
                 joints);
  GltfBuffer shorts;
  shorts.accessor(std::vector<std::uint16_t>{0, 0, 1, 0, 0, 1}, "VEC2", 2);
  expect_warning({.attributes = R"(,"TEXCOORD_0":0)"},
                 "TEXCOORD_0 has the component type 5123, which the standard does not allow without "
                 "KHR_mesh_quantization; it is read all the same",
                 shorts);
  EXPECT_EQ(
      said(asset(
          {.attributes = R"(,"TEXCOORD_0":0)",
           .document = R"(,"extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization"])"},
          shorts)),
      "");
  expect_warning({.document = R"(,"extensionsUsed":["KHR_mesh_quantization"])"},
                 "the extension KHR_mesh_quantization must be among \"extensionsRequired\"");
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
                 "\"attenuationDistance\" is 0; it must be above 0; the volume is clear\n"
                 "the material has a volume, but no light enters it: it has no transmission");
}

TEST(GltfAudit, Extensions) {
  expect_warning(with_material(R"("extensions":{"KHR_materials_unlit":{}})"),
                 R"(the extension "KHR_materials_unlit" is not among "extensionsUsed")");
  expect_warning({.document = R"(,"extensionsRequired":["KHR_texture_transform"])"},
                 "the extension \"KHR_texture_transform\" is required but not among \"extensionsUsed\"\n"
                 "the extension \"KHR_texture_transform\" is required, but nothing in the asset has it");
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
                 "3 of 9 numbers of vertex colours are not between 0 and 1; the nearest of these is used\n"
                 "1 of 9 numbers of the accessor are not finite",
                 colors);
  GltfBuffer skin;
  skin.accessor(std::vector<std::uint8_t>(12), "VEC4", 4);
  skin.accessor(std::vector<float>{1, 0, 0, 0, 0, 0, 0, 0, kNaN, 0, 0, 0}, "VEC4", 4);
  expect_warning({.node = R"(,"skin":0)",
                  .attributes = R"(,"JOINTS_0":0,"WEIGHTS_0":1)",
                  .document = R"(,"skins":[{"joints":[0]}])"},
                 "2 of 3 vertices have no weight above 0; the skin does not move them\n"
                 "1 of 12 numbers of the accessor are not finite\n"
                 "2 vertices have weights that do not add up to 1; they are scaled to it",
                 skin);
}

TEST(GltfAudit, MembersThatTheSchemaDoesNotKnow) {
  expect_warning({.node = R"(,"scales":[1,1,1])"}, R"(a node has no member "scales"; it is ignored)");
  expect_warning(with_material(R"("pbrMetallicRoughness":{"metalness":1})"),
                 R"(a metallic-roughness has no member "metalness"; it is ignored)");
  EXPECT_EQ(said(asset({.node = R"(,"extras":{"scales":1})"})), "");
}

TEST(GltfAudit, MembersOfTheWrongType) {
  expect_said({.document = R"(,"cameras":[4])"}, R"("cameras" is a number; it must be an object)");
  expect_said({.document = R"(,"cameras":[{"type":"fisheye"}])"},
              R"("type" is "fisheye"; it must be one of perspective, orthographic)");
  expect_said({.document = R"(,"skins":[{"joints":[0,0]}])"}, R"("joints" lists 0 twice)");
  expect_said({.document = R"(,"skins":[])"}, R"("skins" is empty; it must have an element or be left out)");
  expect_said({.document = R"(,"samplers":[{"wrapS":1}])"}, R"("wrapS" is 1; it must be one of 33071, 33648, 10497)");
  expect_said({.document = R"(,"animations":[{"channels":[{"sampler":0.5,"target":{}}]}])"},
              R"("sampler" is 0.5; it must be a whole number from 0 on)");
  expect_said({.document = R"(,"animations":[{"channels":[{"sampler":0,"target":{}}]}])"},
              R"(a target has no "path", which it must have)");
  expect_said(
      {.document = R"(,"cameras":[{"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":-1,"zfar":1}}])"},
      R"("znear" is -1; it must be at least 0)");
  expect_said({.document = R"(,"materials":[{"emissiveFactor":[0,1]}])"},
              R"("emissiveFactor" has 2 numbers; it must have 3)");
  expect_said({.document = R"(,"materials":[{"emissiveTexture":{"index":2}}])"},
              R"("index" refers to number 2 of "textures", of which there are 0; it is ignored)");
  expect_said(
      {.document = R"(,"textures":[{"extensions":{"KHR_materials_ior":{}}}],"extensionsUsed":["KHR_materials_ior"])"},
      "a texture cannot have the extension KHR_materials_ior; it is ignored");
}

TEST(GltfAudit, WholeNumbersHaveNoPoint) {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3, kBounds);
  std::string json = one_primitive(buffer, R"("attributes":{"POSITION":0})");
  json.replace(json.find("\"count\":3"), 9, "\"count\":3.0");
  EXPECT_EQ(said(glb(json, buffer.bytes())), "\"count\" is written with a decimal point; it must be a whole number\n");
}

TEST(GltfAudit, Links) {
  GltfBuffer uvs;
  uvs.accessor(std::vector<float>{0, 0, 1, 0}, "VEC2", 2);
  expect_said({.attributes = R"(,"TEXCOORD_0":0)"}, "TEXCOORD_0 has 2 rows, POSITION has 3", uvs);
  expect_said({.attributes = R"(,"TEXCOORD_00":0)"}, "\"TEXCOORD_00\" has no proper number", uvs);
  expect_said({.attributes = R"(,"COLOR_1":0)"}, "COLOR_1 comes without COLOR_0", uvs);
  expect_said({.attributes = R"(,"COLOR_1":0)"}, "COLOR_1 has the type \"VEC2\"; it must be VEC3 VEC4", uvs);
  expect_said({.primitive = R"(,"targets":[{"NORMAL":0}])"}, "a morph target moves NORMAL, which the primitive", uvs);
  expect_said({.primitive = R"(,"targets":[{"POSITION":9}])"}, "POSITION of a morph target refers to an accessor", uvs);
  expect_said({.node = R"(,"skin":0)", .document = R"(,"skins":[{"joints":[0]}])"},
              "the node has a \"skin\", but its mesh has no JOINTS_0");
  expect_said({.node = R"(,"matrix":[1,0.5,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1])"}, "the node's \"matrix\" shears");
  expect_said({.node = R"(},{"skin":0)", .document = R"(,"skins":[{"joints":[0,1]}])"}, "have no common root");
}

// Looking each of them up among all others would take a minute.
TEST(GltfAudit, VeryManyAttributes) {
  std::string attributes;
  for (int i = 0; i < 100000; ++i) attributes += fmt::format(R"(,"_A{}":0)", i);
  const std::clock_t start = std::clock();
  EXPECT_EQ(said(asset({.primitive = R"(,"targets":[{"POSITION":0)" + attributes + "}]", .attributes = attributes})),
            "");
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 15.0);
}

TEST(GltfAudit, NumbersOfAccessors) {
  GltfBuffer wrong;
  wrong.accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC2", 2, R"(,"min":[0,0],"max":[1,2])");
  expect_said({.attributes = R"(,"TEXCOORD_0":0)"}, "\"max\" is 2, but the largest number 1 of a row is 1", wrong);
  GltfBuffer normals;
  normals.accessor(std::vector<float>{0, 0, 2, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
  expect_said({.attributes = R"(,"NORMAL":0)"}, "1 of 3 rows of NORMAL do not have the length 1", normals);
  GltfBuffer shifted;
  shifted.view(std::vector<float>(10));
  shifted.add_accessor(R"("bufferView":0,"byteOffset":2,"componentType":5126,"count":3,"type":"VEC3")");
  expect_said({.attributes = R"(,"_X":0)"}, "\"byteOffset\" is 2; it must be a multiple of 4", shifted);
  GltfBuffer bytes;  // normalised bytes state their bounds as they are written
  bytes.accessor(std::vector<std::uint8_t>{0, 51, 255, 0, 51, 255}, "VEC2", 2,
                 R"(,"normalized":true,"min":[0,0],"max":[255,255])");
  EXPECT_EQ(said(asset({.attributes = R"(,"_X":0)"}, bytes)).find("\"max\""), std::string::npos);
}

TEST(GltfAudit, AnimationsThatAreNotPlayed) {
  GltfBuffer keys;
  keys.accessor(std::vector<float>{-1, -2}, "SCALAR", 1, R"(,"min":[-2],"max":[-1])");
  keys.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 3}, "VEC4", 4);
  const Parts parts{.document = R"(,"animations":[{"samplers":[{"input":0,"output":1}],)"
                                R"("channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}}]}])"};
  expect_said(parts, "the first keyframe is at -1 s; times must not be below 0", keys);
  expect_said(parts, "1 of 2 rotations of the animation do not have the length 1", keys);
  expect_said(parts, "is at -2 s, which is not later than the one before it", keys);
}

TEST(GltfAudit, Containers) {
  const auto word = [](std::uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const std::string good = asset({});
  const auto longer = [&](const std::string& chunk) {
    return good.substr(0, 8) + word(static_cast<std::uint32_t>(good.size() + chunk.size())) + good.substr(12) + chunk;
  };
  EXPECT_NE(said(longer(word(4) + "FOO " + "1234")).find("has the unknown type 0x204f4f46; it is ignored"),
            std::string::npos);
  EXPECT_NE(said(longer(word(4) + "JSON" + "{}  ")).find("is JSON, which must be the first chunk"), std::string::npos);
  EXPECT_NE(said(longer("ab")).find("2 bytes are left over"), std::string::npos);
  EXPECT_NE(said(good + "rest").find("the rest is ignored"), std::string::npos);
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
