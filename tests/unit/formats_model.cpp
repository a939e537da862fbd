/// Mesh files on their own as scenes, and the libraries of materials beside them.

#include "formats/model/model_reader.h"
#include "formats/model/mtl_reader.h"
#include "formats_testing.h"
#include "image/bitmap_file.h"

namespace etendue::testing {
namespace {

std::map<std::string, MtlMaterial> library(std::string_view text, Diagnostics& diagnostics) {
  std::map<std::string, MtlMaterial> materials;
  read_mtl(memory_source(text), "m.mtl", materials, diagnostics);
  return materials;
}

TEST(Mtl, WhatAMaterialSays) {
  Diagnostics diagnostics;
  const auto materials = library(
      "Kd 1 1 1\nnewmtl a b\n Kd 0.1 0.2 0.3\nKs 0.5\nNs 100\nTr 0.25\nKe 5 4 3\n"
      "map_Kd -s 2 3 -o 0.5 0 0 -clamp on wood planks.png\nnewmtl c\nd -halo 0.5\nPm 1\nPr 0.5\n",
      diagnostics);
  EXPECT_EQ(all_messages(diagnostics), "");
  ASSERT_EQ(materials.size(), 2u);
  const MtlMaterial& a = materials.at("a b");
  EXPECT_EQ(a.diffuse, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(a.specular, glm::dvec3(0.5));
  EXPECT_EQ(a.opacity, 0.75);
  EXPECT_EQ(a.emission, glm::dvec3(5, 4, 3));
  ASSERT_TRUE(a.diffuse_map.has_value());
  EXPECT_EQ(a.diffuse_map->filename, "wood planks.png");
  EXPECT_EQ(a.diffuse_map->scale, glm::dvec3(2, 3, 1));
  EXPECT_EQ(a.diffuse_map->offset.x, 0.5);
  EXPECT_TRUE(a.diffuse_map->clamp);
  EXPECT_EQ(materials.at("c").opacity, 0.5);
  EXPECT_EQ(materials.at("c").metallic, 1.0);
}

TEST(Mtl, WhatIsWrongIsLeftOut) {
  Diagnostics diagnostics;
  const auto materials =
      library("newmtl a\nKd 1 x 1\nKd 1 2\nNs nan\nmap_Kd\nKd spectral a.rfl\nnewmtl a\nKd 0 0 0\n", diagnostics);
  EXPECT_FALSE(diagnostics.has_errors());
  EXPECT_EQ(materials.at("a").diffuse, glm::dvec3(0.6));
  EXPECT_NE(all_messages(diagnostics).find("m.mtl:2:1: "), std::string::npos) << all_messages(diagnostics);
  EXPECT_NE(all_messages(diagnostics).find("is there already"), std::string::npos);
}

// An AOV shows what no texture reads: in scenes that ask for it, or where the command does.
TEST(Model, AovsKeepTextureCoordinates) {
  const TemporaryFolder folder;
  folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  const std::string ply = folder.write(
      "m.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 "
      "0\n0 1 0 0 1\n3 0 1 2\n");
  const auto sets = [](const std::string& path, bool shows_uv) {
    Diagnostics diagnostics;
    const auto file = read_scene_file(path, {.shows_uv = shows_uv}, diagnostics);
    EXPECT_TRUE(file.has_value()) << all_messages(diagnostics);
    const Scene& scene = std::get<Scene>(file.value());
    return std::get<TriangleMesh>(scene.shape_of(scene.instances.at(0))).uv_sets.size();
  };
  const auto nori = [&](const std::string& aovs) {
    return folder.write("n.xml", "<scene><integrator type=\"path\"><string name=\"aovs\" value=\"" + aovs +
                                     "\"/></integrator><camera type=\"perspective\"/><mesh type=\"obj\"><string "
                                     "name=\"filename\" value=\"m.obj\"/></mesh></scene>");
  };
  const auto mitsuba = [&](const std::string& aovs) {
    return folder.write("m.xml", "<scene version=\"3.0.0\"><integrator type=\"aov\"><string name=\"aovs\" value=\"" +
                                     aovs + "\"/></integrator><sensor type=\"perspective\"/><shape type=\"obj\">" +
                                     "<string name=\"filename\" value=\"m.obj\"/></shape></scene>");
  };
  EXPECT_EQ(sets(nori("depth"), false), 0u);
  EXPECT_EQ(sets(nori("depth"), true), 1u);
  EXPECT_EQ(sets(nori("depth,uv"), false), 1u);
  EXPECT_EQ(sets(mitsuba("d:depth"), false), 0u);
  EXPECT_EQ(sets(mitsuba("d:depth"), true), 1u);
  EXPECT_EQ(sets(mitsuba("d:depth,u:uv"), false), 1u);
  EXPECT_EQ(sets(ply, false), 0u);
  EXPECT_EQ(sets(ply, true), 1u);
}

TEST(Model, LibrariesAreReadOnce) {
  const TemporaryFolder folder;
  folder.write("m.mtl", "newmtl a\nKd 1 0 0\n");
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 1000; ++i) text += i % 2 == 0 ? "mtllib m.mtl\n" : "mtllib ./m.mtl\n";
  const std::string path = folder.write("m.obj", text + "usemtl a\nf 1 2 3\n");
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  EXPECT_EQ(all_messages(diagnostics).find("is there already"), std::string::npos) << all_messages(diagnostics);
  EXPECT_EQ(std::get<DiffuseBsdf>(std::get<Scene>(*file).materials.at(0).bsdf).albedo.value, glm::dvec3(1, 0, 0));
}

TEST(Model, AnObjWithItsLibrary) {
  const TemporaryFolder folder;
  Bitmap bitmap{.width = 1, .height = 1, .channels = 3, .format = BitmapFormat::u8, .color_space = ColorSpace::srgb};
  bitmap.texels = {std::byte{1}, std::byte{2}, std::byte{3}};
  write_bitmap(folder.path("p.png"), bitmap);
  folder.write(
      "m.mtl",
      "newmtl floor\nmap_Kd p.png\nnewmtl lamp\nKe 5 5 5\nnewmtl glass\nd 0.1\nillum 7\nNi 1.3\nnewmtl none\n");
  const std::string path = folder.write(
      "m.OBJ",
      "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 4\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl floor\nf 1/1 2/2 3/3\nusemtl "
      "lamp\nf 1 2 4\nusemtl floor\nf 3/1 2/2 1/3\nusemtl glass\nf 2 3 4\nusemtl missing\nf 1 3 4\n");
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  const Scene& scene = std::get<Scene>(*file);
  ASSERT_EQ(scene.instances.size(), 4u);
  const auto& floor = std::get<TriangleMesh>(scene.shape_of(scene.instances[0]));
  EXPECT_EQ(floor.triangles.size(), 2u);
  EXPECT_EQ(floor.uv_sets.at(0).size(), floor.positions.size());
  EXPECT_TRUE(std::get<DiffuseBsdf>(scene.bsdf_of(scene.instances[0])).albedo.texture.has_value());
  EXPECT_EQ(scene.emitter_of(scene.instances[1])->radiance.value, glm::dvec3(5.0));
  EXPECT_EQ(std::get<DielectricBsdf>(scene.bsdf_of(scene.instances[2])).int_ior, 1.3);
  EXPECT_TRUE(std::get<TriangleMesh>(scene.shape_of(scene.instances[3])).uv_sets.empty());
  EXPECT_NE(all_messages(diagnostics).find("no library has the material \"missing\""), std::string::npos);
  EXPECT_NE(all_messages(diagnostics).find("a mesh alone"), std::string::npos);
  // The whole of it is in front of the camera, within its view.
  const glm::dmat4 camera_from_world = glm::inverse(scene.camera.world_from_camera);
  for (const glm::dvec4& p :
       {glm::dvec4(0, 0, 0, 1), glm::dvec4(1, 0, 0, 1), glm::dvec4(0, 1, 0, 1), glm::dvec4(0, 0, 4, 1)}) {
    const glm::dvec4 local = camera_from_world * p;
    EXPECT_GT(local.z, scene.camera.near_clip);
    EXPECT_LT(std::hypot(local.x, local.y) / local.z, std::tan(glm::radians(scene.camera.fov / 2.0)));
  }
}

TEST(Model, OpacityIsAMask) {
  const TemporaryFolder folder;
  for (const std::uint32_t channels : {3u, 4u}) {
    Bitmap bitmap{
        .width = 1, .height = 1, .channels = channels, .format = BitmapFormat::u8, .color_space = ColorSpace::srgb};
    bitmap.texels.resize(channels, std::byte{128});
    write_bitmap(folder.path(channels == 4 ? "rgba.png" : "rgb.png"), bitmap);
  }
  folder.write("m.mtl",
               "newmtl veil\nd 0.25\nnewmtl leaf\nmap_Kd rgba.png\nmap_d rgba.png\nnewmtl holes\nd 0\nmap_d rgb.png\n"
               "newmtl solid\nKd 1 1 1\n");
  const std::string path = folder.write(
      "m.obj",
      "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl veil\nf 1 2 3\nusemtl leaf\n"
      "f 1/1 2/2 3/3\nusemtl holes\nf 1/1 2/2 3/3\nusemtl solid\nf 1 2 3\n");
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  const Scene& scene = std::get<Scene>(*file);
  ASSERT_EQ(scene.instances.size(), 4u);
  const auto opacity = [&](std::size_t i) {
    return std::get<MaskAdapter>(scene.materials.at(scene.instances[i].material).adapter.value()).opacity;
  };
  EXPECT_EQ(opacity(0).value, 0.25);
  EXPECT_FALSE(opacity(0).texture.has_value());
  EXPECT_EQ(opacity(1).channel, TextureChannel::alpha);
  EXPECT_EQ(opacity(2).channel, TextureChannel::luminance);
  EXPECT_EQ(opacity(2).value, 1.0);
  EXPECT_EQ(std::get<BitmapTexture>(scene.textures.at(*opacity(2).texture).source).color_space, ColorSpace::linear);
  EXPECT_FALSE(std::get<TriangleMesh>(scene.shape_of(scene.instances[2])).uv_sets.empty());
  EXPECT_FALSE(scene.materials.at(scene.instances[3].material).adapter.has_value());
}

TEST(Model, APlyShowsItsColours) {
  const TemporaryFolder folder;
  const std::string path = folder.write(
      "m.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "r\n"
      "property float g\nproperty float b\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 1 0 0\n1 0 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2\n");
  Diagnostics diagnostics;
  const auto file = read_scene_file(path, {.environment = "", .camera = "0,0,9 0,0,0 30"}, diagnostics);
  ASSERT_TRUE(file.has_value()) << all_messages(diagnostics);
  const Scene& scene = std::get<Scene>(*file);
  EXPECT_EQ(std::get<TriangleMesh>(scene.shapes.at(0)).vertex_colors.size(), 3u);
  EXPECT_TRUE(std::holds_alternative<AttributeTexture>(scene.textures.at(0).source));
  EXPECT_EQ(scene.camera.fov, 30.0);
  EXPECT_EQ(scene.camera.world_from_camera[3], glm::dvec4(0, 0, 9, 1));
  Diagnostics refused;
  EXPECT_FALSE(read_scene_file(path, {.camera = "0,0,9"}, refused).has_value());
  EXPECT_NE(all_messages(refused).find("3 numbers; write 3 for the eye"), std::string::npos);
  EXPECT_FALSE(read_scene_file(path, {.environment = folder.path("none.exr")}, refused).has_value());
  EXPECT_FALSE(read_scene_file(path, {.overrides = {{"camera.fov", "3"}}}, refused).has_value());
}

}  // namespace
}  // namespace etendue::testing
