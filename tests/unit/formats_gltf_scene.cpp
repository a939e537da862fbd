/// Cameras, lamps and materials of glTF assets.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gltf_files.h"
#include "image/bitmap_file.h"
#include "scene/materials.h"

namespace etendue::testing {
namespace {

/// A triangle with texture coordinates, in a document with those members besides; `nodes` come after that of the mesh.
std::string asset(const std::string& more, const std::string& primitive = "", const std::string& nodes = "",
                  const std::string& version = R"("version":"2.0")") {
  GltfBuffer buffer;
  buffer.accessor(right_triangle(), "VEC3", 3);
  buffer.accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC2", 2);
  buffer.accessor(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 3);
  std::string roots = "0";
  for (int i = 1; i <= static_cast<int>(std::count(nodes.begin(), nodes.end(), '#')); ++i)
    roots += fmt::format(",{}", i);
  std::string rest = nodes;
  std::ranges::replace(rest, '#', ',');
  const std::string json = fmt::format(
      R"({{"asset":{{{}}},"scenes":[{{"nodes":[{}]}}],"nodes":[{{"mesh":0}}{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}}{}}}]}}],{}{}}})",
      version, roots, rest, primitive, buffer.json(), more.empty() ? "" : "," + more);
  return glb(json, buffer.bytes());
}

GltfRead with_camera(const std::string& camera, const ReadOptions& options = {}) {
  return read_asset(asset(fmt::format(R"("cameras":[{}])", camera), "",
                          R"(#{"name":"eye","camera":0,"translation":[0,0,5],"scale":[3,3,3]})"
                          R"(#{"name":"other","camera":0,"translation":[0,0,9],"rotation":[0,1,0,0]})"),
                    options);
}

TEST(GltfCamera, PerspectiveWithAndWithoutAnEnd) {
  const GltfRead read =
      with_camera(R"({"type":"perspective","perspective":{"yfov":1.5707963267948966,"znear":0.5,"aspectRatio":2}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const Camera& camera = read.scene->camera;
  EXPECT_NEAR(camera.fov, 90.0, 1e-12);
  EXPECT_EQ(camera.fov_axis, Camera::FovAxis::y);
  EXPECT_EQ(camera.width, 1440u);
  EXPECT_EQ(camera.near_clip, 0.5);
  EXPECT_GE(camera.far_clip, 1e6);
  EXPECT_EQ(camera.world_from_camera[3], glm::dvec4(0, 0, 5, 1));
  EXPECT_EQ(camera.world_from_camera[2], glm::dvec4(0, 0, -1, 0));  // glTF looks along −Z
  EXPECT_EQ(camera.world_from_camera[1], glm::dvec4(0, 1, 0, 0));
  EXPECT_EQ(camera.world_from_camera[0], glm::dvec4(-1, 0, 0, 0));
}

TEST(GltfCamera, OrthographicShowsItsMagnitudes) {
  const GltfRead read = with_camera(R"({"type":"orthographic","orthographic":{"xmag":4,"ymag":2,"znear":1,"zfar":8}})");
  ASSERT_TRUE(read.scene.has_value()) << read.messages();
  const Camera& camera = read.scene->camera;
  EXPECT_EQ(camera.type, Camera::Type::orthographic);
  EXPECT_EQ(camera.world_from_camera[0], glm::dvec4(-4, 0, 0, 0));  // half the width
  EXPECT_EQ(film_aspect(camera), 0.5);
  EXPECT_EQ(camera.near_clip * glm::length(camera.world_from_camera[2]), 1.0);
  EXPECT_EQ(camera.far_clip * glm::length(camera.world_from_camera[2]), 8.0);
}

TEST(GltfCamera, IsChosenByNameOrNumber) {
  const std::string camera = R"({"name":"lens","type":"perspective","perspective":{"yfov":1,"znear":0.1}})";
  const auto z = [&](const std::string& choice) {
    return with_camera(camera, {.camera = choice}).scene.value().camera.world_from_camera[3].z;
  };
  EXPECT_EQ(z(""), 5.0);
  EXPECT_EQ(z("other"), 9.0);
  EXPECT_EQ(z("1"), 9.0);
  EXPECT_EQ(z("lens"), 5.0);
  EXPECT_NE(with_camera(camera, {.camera = "no"}).messages().find("\"eye\", \"other\""), std::string::npos);
}

TEST(GltfCamera, WhatIsWrongIsAnError) {
  for (const char* camera :
       {R"({"type":"perspective"})", R"({"type":"perspective","perspective":{"yfov":0,"znear":1}})",
        R"({"type":"fisheye"})", R"({"type":"orthographic","orthographic":{"xmag":0,"ymag":1}})",
        R"({"type":"perspective","perspective":{"yfov":1,"znear":3,"zfar":2}})"})
    EXPECT_FALSE(with_camera(camera).scene.has_value()) << camera;
}

GltfRead with_light(const std::string& light, const ReadOptions& options = {},
                    const std::string& version = R"("version":"2.0")") {
  return read_asset(
      asset(
          fmt::format(R"("extensions":{{"KHR_lights_punctual":{{"lights":[{}]}}}})", light), "",
          R"(#{"translation":[0,3,0],"rotation":[-0.7071067811865476,0,0,0.7071067811865476],"extensions":{"KHR_lights_punctual":{"light":0}}})",
          version),
      options);
}

TEST(GltfLights, PointsSpotsAndDirections) {
  const GltfRead point = with_light(R"({"type":"point","color":[1,0.5,0],"intensity":20})");
  ASSERT_TRUE(point.scene.has_value()) << point.messages();
  EXPECT_EQ(point.scene->delta_lights.at(0).intensity.value, glm::dvec3(20, 10, 0));  // candela
  EXPECT_EQ(point.scene->delta_lights[0].origin(), glm::dvec3(0, 3, 0));
  EXPECT_EQ(point.scene->sky.top, glm::dvec3(0.0));  // no studio
  const GltfRead spot = with_light(R"({"type":"spot","spot":{"innerConeAngle":0.1,"outerConeAngle":0.5}})");
  ASSERT_TRUE(spot.scene.has_value()) << spot.messages();
  const DeltaLight& s = spot.scene->delta_lights.at(0);
  EXPECT_EQ(s.type, DeltaLight::Type::spot);
  EXPECT_NEAR(s.cutoff, 0.5 * 180.0 / std::numbers::pi, 1e-12);
  EXPECT_NEAR(s.beam_width, 0.1 * 180.0 / std::numbers::pi, 1e-12);
  EXPECT_LT(glm::distance(s.axis(2), glm::dvec3(0, -1, 0)), 1e-12);  // turned downward
  const GltfRead sun = with_light(R"({"type":"directional","intensity":7})");
  EXPECT_EQ(sun.scene.value().delta_lights.at(0).intensity.value, glm::dvec3(7.0));  // lux
  EXPECT_EQ(sun.scene->delta_lights[0].type, DeltaLight::Type::directional);
  for (const char* wrong :
       {R"({"type":"laser"})", R"({"type":"spot","spot":{"innerConeAngle":1,"outerConeAngle":0.5}})", R"({})"})
    EXPECT_FALSE(with_light(wrong).scene.has_value()) << wrong;
}

TEST(GltfLights, LampsOfBlenderAreDividedByItsFactor) {
  const std::string light = R"({"type":"point","intensity":683})";
  const std::string blender = R"("version":"2.0","generator":"Khronos glTF Blender I/O v4.2.57")";
  const auto intensity = [&](const std::string& version, GltfLamps lamps) {
    return with_light(light, {.lamps = lamps}, version).scene.value().delta_lights.at(0).intensity.value.x;
  };
  EXPECT_EQ(intensity(blender, GltfLamps::automatic), 1.0);
  EXPECT_EQ(intensity(blender, GltfLamps::standard), 683.0);
  EXPECT_EQ(intensity(R"("version":"2.0")", GltfLamps::automatic), 683.0);
  EXPECT_EQ(intensity(R"("version":"2.0")", GltfLamps::blender), 1.0);
  EXPECT_NEAR(intensity(blender, GltfLamps::watts), 683.0 / (4.0 * std::numbers::pi), 1e-12);
  // Half a right angle with a blend of 0.15: Blender fades from cos 45° over 0.15 (1 − cos 45°).
  for (const GltfLamps lamps : {GltfLamps::automatic, GltfLamps::standard, GltfLamps::watts}) {
    const GltfRead spot =
        with_light(fmt::format(R"({{"type":"spot","spot":{{"innerConeAngle":{},"outerConeAngle":{}}}}})",
                               0.85 * std::numbers::pi / 4.0, std::numbers::pi / 4.0),
                   {.lamps = lamps}, blender);
    const double beam = spot.scene.value().delta_lights.at(0).beam_width * std::numbers::pi / 180.0;
    EXPECT_NEAR(std::cos(beam), std::sqrt(0.5) + 0.15 * (1.0 - std::sqrt(0.5)), 1e-12);
  }
}

}  // namespace
}  // namespace etendue::testing
