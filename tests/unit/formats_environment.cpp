/// Light from all around a scene, in scene files.

#include <gmock/gmock.h>

#include "formats_testing.h"

namespace etendue {
namespace {

using namespace etendue::testing;
using ::testing::HasSubstr;

/// A picture of 2 x 1 pixels, 1 and 2.
std::string hdr_bytes() {
  return std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n") + "\x80\x80\x80\x81" + "\x80\x80\x80\x82";
}

std::string envmap(const std::string& content) {
  return "<emitter type=\"envmap\">" + content + "</emitter>";
}

/// Of a scene file in a folder with sky.hdr.
Parsed parse_beside_sky(const TemporaryFolder& folder, const std::string& content) {
  folder.write("sky.hdr", hdr_bytes());
  Parsed result;
  result.file = parse_scene_file(scene_around(content), folder.path("s.xml"), {}, load_triangle, result.diagnostics);
  return result;
}

TEST(SceneEnvironment, ReadsAPicture) {
  const TemporaryFolder folder;
  const Parsed parsed =
      parse_beside_sky(folder, envmap("<string name=\"filename\" value=\"sky.hdr\"/><float name=\"scale\" value=\"3\"/>"
                                      "<string name=\"rows\" value=\"circles\"/><transform name=\"toWorld\">"
                                      "<scale value=\"-2 2 2\"/><rotate axis=\"0 1 0\" angle=\"90\"/></transform>"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  const Sky& sky = parsed.scene().sky;
  ASSERT_TRUE(sky.picture);
  EXPECT_EQ(sky.picture->bitmap->width, 2u);
  EXPECT_EQ(sky.picture->rows, SkyPicture::Rows::circles);
  EXPECT_EQ(sky.picture->radiance(1, 0), glm::vec3(6.0f));
  EXPECT_LT(glm::length(sky.world_from_sky * glm::dvec3(1, 0, 0) - glm::dvec3(0, 0, 2)), 1e-9);
}

TEST(SceneEnvironment, ReadsAConstant) {
  const Parsed parsed =
      parse(scene_around("<emitter type=\"constant\"><color name=\"radiance\" value=\"1 2 3\"/></emitter>"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  EXPECT_EQ(parsed.scene().sky.top, glm::dvec3(1, 2, 3));
  EXPECT_EQ(parsed.scene().sky.horizon, glm::dvec3(1, 2, 3));
}

TEST(SceneEnvironment, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  folder.write("bad.hdr", "GIF89a");
  folder.write("pointer.hdr", "version https://git-lfs.github.com/spec/v1\n");
  const std::string file = "<string name=\"filename\" value=\"sky.hdr\"/>";
  const std::string constant = "<emitter type=\"constant\"/>";
  const struct {
    std::string content;
    const char* message;
  } cases[] = {
      {envmap("<string name=\"filename\" value=\"none.hdr\"/>"), ":2:55: picture "},
      {envmap("<string name=\"filename\" value=\"bad.hdr\"/>"), "not a PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR"},
      {envmap("<string name=\"filename\" value=\"pointer.hdr\"/>"), "Git LFS pointer"},
      {envmap("<string name=\"filename\" value=\" \"/>"), "give the path of a picture"},
      {envmap(""), "filename"},
      {envmap(file + "<string name=\"rows\" value=\"band\"/>"),
       "\"band\" is not a kind of rows; did you mean \"bands\"?"},
      {envmap(file + "<float name=\"scale\" value=\"0\"/>"), "scale"},
      {envmap(file + "<float name=\"scale\" value=\"1e30\"/>"), "use at most"},
      {envmap(file + "<transform name=\"toWorld\"><scale value=\"1 2 1\"/></transform>"),
       "scales it unevenly or shears it"},
      {envmap(file) + constant, "emitter"},
      {constant + "<color name=\"sky_top\" value=\"1 1 1\"/>", "two skies"},
      {"<emitter type=\"area\"><color name=\"radiance\" value=\"1 1 1\"/></emitter>", "belongs in the mesh that emits"},
      {"<mesh type=\"sphere\">" + constant + "</mesh>", "move it into <scene>"},
  };
  for (const auto& [content, message] : cases) {
    const Parsed parsed = parse_beside_sky(folder, content);
    EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr(message)) << content;
    EXPECT_GT(parsed.diagnostics.error_count(), 0u) << content;
  }
}

TEST(SceneEnvironment, TheHashKnowsThePicture) {
  const TemporaryFolder folder;
  const std::string file = "<string name=\"filename\" value=\"sky.hdr\"/>";
  const auto hash = [&](const std::string& content) { return scene_hash(parse_beside_sky(folder, content).scene()); };
  const std::uint64_t plain = hash(envmap(file));
  EXPECT_NE(plain, hash(""));
  EXPECT_NE(plain, hash(envmap(file + "<float name=\"scale\" value=\"2\"/>")));
  EXPECT_NE(plain, hash(envmap(file + "<string name=\"rows\" value=\"circles\"/>")));
  EXPECT_NE(plain,
            hash(envmap(file + "<transform name=\"toWorld\"><rotate axis=\"0 1 0\" angle=\"90\"/></transform>")));
  EXPECT_EQ(plain, hash(envmap(file)));
}

}  // namespace
}  // namespace etendue
