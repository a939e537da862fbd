// Scenes of objects in memory: the same scenes as their text has, and places that are paths of names.

#include "formats/scene_objects.h"

#include "formats/read_scene.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

using Properties = std::vector<std::pair<std::string, SceneValue>>;

SceneObject object(std::string type, Properties properties = {}) {
  return {.type = std::move(type), .properties = std::move(properties), .mesh = {}, .bitmap = {}};
}
SceneValue held(std::string type, Properties properties = {}) {
  return std::make_shared<SceneObject>(object(std::move(type), std::move(properties)));
}
SceneValue grey(double value) {
  return held("rgb", {{"value", value}});
}

SceneObject scene_with(Properties more) {
  Properties all = {{"sensor", held("perspective", {{"fov", 40.0}})}};
  for (auto& property : more) all.push_back(std::move(property));
  return object("scene", std::move(all));
}

std::optional<Scene> read(SceneObject root, Diagnostics& diagnostics) {
  return read_scene_objects(std::move(root), {}, diagnostics);
}
std::string first_error(Properties more) {
  Diagnostics diagnostics;
  EXPECT_FALSE(read(scene_with(std::move(more)), diagnostics));
  return diagnostics.list().empty() ? "" : to_string(diagnostics.list().front());
}

TEST(SceneObjects, AreTheSceneOfTheirText) {
  const TemporaryFolder folder;
  const std::string file = folder.write("scene.xml", R"(<scene version="3.0.0">
    <integrator type="direct"><integer name="emitter_samples" value="3"/></integrator>
    <sensor type="perspective"><float name="fov" value="40"/>
      <transform name="to_world"><lookat origin="0,1,6" target="0,1,0" up="0,1,0"/></transform>
      <film type="hdrfilm"><integer name="width" value="64"/><integer name="height" value="48"/><rfilter type="tent"/></film>
    </sensor>
    <bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.7, 0.6"/></bsdf></bsdf>
    <shape type="sphere"><point name="center" value="0, 1, 0"/><float name="radius" value="2"/><ref id="white"/></shape>
    <shape type="rectangle"><bsdf type="roughconductor"><string name="material" value="Cu"/>
      <texture type="checkerboard" name="alpha"/></bsdf><emitter type="area"><spectrum name="radiance" type="d65"/></emitter></shape>
    <emitter type="point"><point name="position" value="1, 2, 3"/><rgb name="intensity" value="4"/></emitter>
    </scene>)");
  glm::dmat4 eye(1.0);
  eye[0] = {-1.0, 0.0, 0.0, 0.0};
  eye[2] = {0.0, 0.0, -1.0, 0.0};
  eye[3] = {0.0, 1.0, 6.0, 1.0};
  Diagnostics diagnostics;
  const std::optional<Scene> made = read(
      object("scene",
             {{"how", held("direct", {{"emitter_samples", std::int64_t{3}}})},
              {"eye", held("perspective", {{"fov", std::int64_t{40}},
                                           {"to_world", eye},
                                           {"film", held("hdrfilm", {{"width", std::int64_t{64}},
                                                                     {"height", std::int64_t{48}},
                                                                     {"filter", held("tent")}})}})},
              {"white", held("twosided", {{"inner", held("diffuse", {{"reflectance", std::vector{0.8, 0.7, 0.6}}})}})},
              {"ball", held("sphere", {{"center", std::vector{0.0, 1.0, 0.0}},
                                       {"radius", 2.0},
                                       {"bsdf", held("ref", {{"id", std::string("white")}})}})},
              {"lamp", held("rectangle", {{"bsdf", held("roughconductor", {{"material", std::string("Cu")},
                                                                           {"alpha", held("checkerboard")}})},
                                          {"emitter", held("area", {{"radiance", held("d65")}})}})},
              {"point", held("point", {{"position", std::vector{1.0, 2.0, 3.0}}, {"intensity", grey(4.0)}})}}),
      diagnostics);
  ASSERT_TRUE(made.has_value()) << all_messages(diagnostics);
  Scene read = read_scene(file);
  EXPECT_EQ(scene_hash(*made), scene_hash(read));
  EXPECT_EQ(made->camera.world_from_camera, read.camera.world_from_camera);
  EXPECT_EQ(made->camera.fov, read.camera.fov);
  EXPECT_EQ(made->camera.width, 64u);
  EXPECT_EQ(made->camera.filter.type, ReconstructionFilter::Type::tent);
  EXPECT_EQ(made->integrator.emitter_samples, 3u);
  read.camera.fov = 41.0;
  EXPECT_NE(scene_hash(*made), scene_hash(read)) << "the hash does not see the camera, so this test sees little";
}

TEST(SceneObjects, HoldMeshesAndPictures) {
  SceneObject mesh = object("mesh", {{"bsdf", held("diffuse")}});
  mesh.mesh = TriangleMesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  mesh.mesh->uv_sets = {{{0, 0}, {1, 0}, {0, 1}}};
  SceneObject picture = object("bitmap");
  picture.bitmap =
      Bitmap{.width = 1, .height = 1, .channels = 1, .format = BitmapFormat::u8, .texels = {std::byte{255}}};
  std::get<std::shared_ptr<SceneObject>>(mesh.properties[0].second)
      ->properties.emplace_back("reflectance", std::make_shared<SceneObject>(std::move(picture)));
  Diagnostics diagnostics;
  const auto made = read(scene_with({{"triangle", std::make_shared<SceneObject>(std::move(mesh))}}), diagnostics);
  ASSERT_TRUE(made.has_value()) << all_messages(diagnostics);
  const auto& triangle = std::get<TriangleMesh>(made->shapes.at(0));
  EXPECT_EQ(triangle.positions.size(), 3u);
  EXPECT_TRUE(triangle.normals.empty());
  EXPECT_EQ(triangle.uv_sets.at(0)[2], glm::vec2(0.0f, 0.0f)) << "v counts from the first row";
  EXPECT_EQ(made->bitmaps.size(), 1u);
  EXPECT_EQ(made->instances[0].position.file, "dict:/triangle");
}

TEST(SceneObjects, ErrorsHaveTheirPlace) {
  EXPECT_EQ(first_error({{"ball", held("spere")}}), "dict:/ball: there is no type \"spere\"; did you mean \"sphere\"?");
  EXPECT_EQ(
      first_error(
          {{"ball", held("sphere", {{"bsdf", held("diffuse", {{"reflectance",
                                                               held("rgb", {{"value", std::vector{1.0, 2.0}}})}})}})}}),
      "dict:/ball/bsdf/reflectance: \"reflectance\" of <bsdf type=\"diffuse\">: expected 1 or 3 numbers, found 2");
  EXPECT_EQ(first_error({{"ball", held("sphere", {{"radius", -1.0}})}}),
            "dict:/ball/radius: \"radius\" of <shape type=\"sphere\">: -1 is out of range; allowed is > 0");
  SceneObject mesh = object("mesh");
  mesh.mesh = TriangleMesh{.positions = {{0, 0, 0}}, .triangles = {{0, 0, 1}}};
  EXPECT_EQ(first_error({{"m", std::make_shared<SceneObject>(std::move(mesh))}}),
            "dict:/m: triangle 0 has the vertex 1; there are 1, counted from 0");
  SceneValue deep = held("twosided");
  for (std::size_t i = 0; i < kMaxObjectDepth; ++i) deep = held("twosided", {{"inner", deep}});
  EXPECT_NE(first_error({{"deep", deep}}).find("nested deeper than 32 levels"), std::string::npos);
}

}  // namespace
}  // namespace etendue::testing
