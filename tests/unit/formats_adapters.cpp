/// Materials in materials, as files say it.

#include <gmock/gmock.h>

#include "formats_testing.h"

namespace etendue::testing {
namespace {

using ::testing::HasSubstr;

std::string sphere(const std::string& bsdf) {
  return scene_around("<mesh type=\"sphere\">" + bsdf + "</mesh>");
}

TEST(FormatsAdapters, BecomeRowsBehindWhatTheyChooseFrom) {
  const Parsed parsed = parse(sphere(R"(<bsdf type="mask"><float name="opacity" value="0.25"/>
      <bsdf type="twosided"><bsdf type="mirror"/><bsdf type="blend"><float name="weight" value="0.75"/>
      <bsdf type="diffuse"/><bsdf type="conductor"/></bsdf></bsdf></bsdf>)"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  const Scene& scene = parsed.scene();
  ASSERT_EQ(scene.materials.size(), 6u);
  EXPECT_EQ(scene.instances[0].material, 5u);
  const auto& mask = std::get<MaskAdapter>(scene.materials[5].adapter.value());
  EXPECT_EQ(mask.opacity.value, 0.25);
  EXPECT_EQ(mask.inner, 4u);
  const auto& sides = std::get<TwoSidedAdapter>(scene.materials[4].adapter.value());
  EXPECT_EQ(sides.front, 0u);
  EXPECT_EQ(sides.back, 3u);
  const auto& blend = std::get<BlendAdapter>(scene.materials[3].adapter.value());
  EXPECT_EQ(blend.weight.value, 0.75);
  EXPECT_EQ(blend.first, 1u);
  EXPECT_EQ(blend.second, 2u);
  EXPECT_TRUE(std::holds_alternative<MirrorBsdf>(scene.materials[0].bsdf));
}

TEST(FormatsAdapters, ShareMaterialsByReference) {
  const Parsed parsed =
      parse(scene_around(R"(<bsdf type="diffuse" id="d"/><bsdf type="twosided" id="t"><ref id="d"/></bsdf>
      <mesh type="sphere"><ref id="t"/></mesh><mesh type="sphere"><ref id="d"/></mesh>)"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  EXPECT_EQ(parsed.scene().materials.size(), 2u);
  EXPECT_EQ(parsed.scene().instances[0].material, 1u);
  EXPECT_EQ(parsed.scene().instances[1].material, 0u);
}

TEST(FormatsAdapters, TakeAChannelOfATexture) {
  const Parsed parsed = parse(scene_around(R"(<mesh type="rectangle"><bsdf type="mask">
      <texture name="opacity" type="checkerboard"><string name="channel" value="alpha"/></texture><bsdf type="null"/></bsdf></mesh>)"));
  ASSERT_TRUE(parsed.file) << all_messages(parsed.diagnostics);
  const auto& mask = std::get<MaskAdapter>(parsed.scene().materials[1].adapter.value());
  EXPECT_EQ(mask.opacity.texture, 0u);
  EXPECT_EQ(mask.opacity.channel, TextureChannel::alpha);
}

TEST(FormatsAdapters, MistakesAreNamed) {
  const auto refused = [](const std::string& bsdf, const std::string& words) {
    const Parsed parsed = parse(sphere(bsdf));
    EXPECT_FALSE(parsed.file);
    EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr(words));
  };
  refused(R"(<bsdf type="twosided"/>)", "needs");
  refused(R"(<bsdf type="blend"><bsdf type="diffuse"/></bsdf>)", "2");
  refused(R"(<bsdf type="twosided"><bsdf type="dielectric"/></bsdf>)", "\"dielectric\" transmits light");
  refused(R"(<bsdf type="mask"><float name="opacity" value="2"/><bsdf type="diffuse"/></bsdf>)", "opacity");
  refused(
      R"(<bsdf type="mask"><texture name="opacity" type="checkerboard"><string name="channel" value="luma"/></texture>
      <bsdf type="diffuse"/></bsdf>)",
      "\"luma\" is not a texture channel");
}

TEST(FormatsAdapters, AreTestedOnAPatch) {
  const Parsed test = parse(R"(<test type="chi2test"><string name="uv" value="0.7, 0.1"/>
    <bsdf type="blend"><bsdf type="diffuse"/><bsdf type="mask"><bsdf type="mirror"/></bsdf></bsdf>
    <bsdf type="diffuse"><texture name="albedo" type="checkerboard"/></bsdf></test>)");
  ASSERT_TRUE(test.file) << all_messages(test.diagnostics);
  const std::vector<TestBsdf>& bsdfs = std::get<Chi2Test>(*test.file).bsdfs;
  ASSERT_EQ(bsdfs.size(), 2u);
  EXPECT_EQ(bsdfs[0].name, "blend 1");
  ASSERT_EQ(bsdfs[0].patch.materials.size(), 4u);
  EXPECT_EQ(bsdfs[0].patch.instances.front().material, 3u);
  EXPECT_TRUE(std::holds_alternative<BlendAdapter>(*bsdfs[0].patch.materials[3].adapter));
  EXPECT_EQ(bsdfs[1].patch.materials.size(), 1u);
  EXPECT_EQ(bsdfs[1].patch.textures.size(), 1u);
  EXPECT_EQ(std::get<TriangleMesh>(bsdfs[1].patch.shapes.front()).uv_sets[0][0], glm::vec2(0.7f, 0.1f));
  const auto refused = [](const std::string& test_file, const std::string& words) {
    const Parsed parsed = parse(test_file);
    EXPECT_FALSE(parsed.file);
    EXPECT_THAT(all_messages(parsed.diagnostics), HasSubstr(words));
  };
  refused(R"(<test type="chi2test"><bsdf type="twosided"><bsdf type="dielectric"/></bsdf></test>)", "transmits light");
  refused(R"(<test type="chi2test"><string name="uv" value="1"/><bsdf type="diffuse"/></test>)", "give two, u and v");
}

}  // namespace
}  // namespace etendue::testing
