/// Shape groups and instances in scene files.

#include "formats_testing.h"
#include "scene/sharing.h"

namespace etendue::testing {
namespace {

const char* const kGroup = R"(
<shape type="shapegroup" id="fir">
  <shape type="obj"><string name="filename" value="crown.obj"/>
    <transform name="toWorld"><scale value="2 2 2"/></transform>
    <bsdf type="mirror"/></shape>
  <shape type="obj"><string name="filename" value="lamp.obj"/>
    <emitter type="area"><color name="radiance" value="1 2 3"/></emitter></shape>
</shape>
)";

std::string instance_at(const std::string& x) {
  return "<shape type=\"instance\"><ref id=\"fir\"/><transform name=\"toWorld\"><translate value=\"" + x +
         " 0 0\"/></transform></shape>\n";
}

std::string scene_of(const std::string& content) {
  return "<scene>\n<integrator type=\"path\"/><camera type=\"perspective\"/>\n" + content + "</scene>";
}

TEST(SceneInstances, AGroupIsSeenOnlyWhereInstancesShowIt) {
  const Parsed parsed = parse(scene_of(kGroup + instance_at("5") + instance_at("-3")));
  ASSERT_TRUE(parsed.file.has_value());
  const auto& scene = std::get<Scene>(*parsed.file);
  ASSERT_EQ(scene.instances.size(), 4u);
  EXPECT_EQ(scene.shapes.size(), 2u);
  EXPECT_EQ(scene.emitters.size(), 1u);
  for (std::size_t i = 0; i < 4; ++i) {
    const Instance& instance = scene.instances[i];
    EXPECT_EQ(instance.shape, i % 2);
    EXPECT_EQ(std::holds_alternative<MirrorBsdf>(scene.bsdf_of(instance)), i % 2 == 0);
    EXPECT_EQ(instance.emitter.has_value(), i % 2 == 1);
    EXPECT_EQ(instance.world_from_object[3], glm::dvec4(i < 2 ? 5 : -3, 0, 0, 1));
    EXPECT_EQ(instance.world_from_object[0].x, i % 2 == 0 ? 2.0 : 1.0) << "the shape's transform comes first";
    EXPECT_EQ(instance.name, i % 2 == 0 ? "crown.obj" : "lamp.obj");
  }
}

TEST(SceneInstances, TheGroupMayStandBehindItsInstances) {
  const Parsed parsed = parse(scene_of(instance_at("1") + kGroup));
  ASSERT_TRUE(parsed.file.has_value());
  EXPECT_EQ(std::get<Scene>(*parsed.file).instances.size(), 2u);
}

TEST(SceneInstances, AFileThatIsNamedTwiceIsReadOnce) {
  const std::string mesh = "<mesh type=\"obj\"><string name=\"filename\" value=\"a.obj\"/></mesh>";
  const Parsed parsed =
      parse(scene_of(mesh + mesh + "<mesh type=\"obj\"><string name=\"filename\" value=\"b.obj\"/></mesh>"));
  ASSERT_TRUE(parsed.file.has_value());
  const auto& scene = std::get<Scene>(*parsed.file);
  EXPECT_EQ(scene.shapes.size(), 2u);
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.instances[0].shape, scene.instances[1].shape);
  EXPECT_EQ(scene.instances[1].name, "a.obj");
  EXPECT_FALSE(Sharing(scene).any()) << "small scenes stay flat";
}

TEST(SceneInstances, InstancingIsSaidByAWord) {
  const Parsed parsed =
      parse(scene_of("<string name=\"instancing\" value=\"always\"/>" + std::string(kGroup) + instance_at("1")));
  ASSERT_TRUE(parsed.file.has_value());
  EXPECT_TRUE(Sharing(std::get<Scene>(*parsed.file)).has_instance(1));
}

TEST(SceneInstances, MistakesAreNamed) {
  const auto expect = [](const std::string& content, const std::string& sentence) {
    const Parsed parsed = parse(scene_of(content));
    std::string all;
    for (const Diagnostic& d : parsed.diagnostics.list()) all += to_string(d) + "\n";
    EXPECT_NE(all.find(sentence), std::string::npos) << all;
  };
  const std::string group = kGroup;
  expect(group + "<shape type=\"instance\"/>", "the instance shows nothing");
  expect(group + "<shape type=\"instance\"><ref id=\"first\"/></shape>", "nothing in this file has the id \"first\"");
  expect("<mesh type=\"sphere\" id=\"ball\"/><shape type=\"instance\"><ref id=\"ball\"/></shape>",
         "an instance shows a <shape type=\"shapegroup\">");
  expect("<shape type=\"shapegroup\"><mesh type=\"sphere\"/></shape>", "the shape group needs an id");
  expect(group + instance_at("1") + "<shape type=\"shapegroup\" id=\"wood\">" + instance_at("1") +
             "</shape>"
             "<shape type=\"instance\"><ref id=\"wood\"/></shape>",
         "instances are one level deep");
  expect(group, "no instance shows the shape group \"fir\"");
  expect("<string name=\"instancing\" value=\"alway\"/>", "did you mean \"always\"");
  expect(group +
             "<shape type=\"instance\"><ref id=\"fir\"/><transform name=\"toWorld\"><scale value=\"0 1 "
             "1\"/></transform></shape>",
         "is singular");
}

}  // namespace
}  // namespace etendue::testing
