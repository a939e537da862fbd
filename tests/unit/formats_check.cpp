// Legal but probably not meant: each warning appears where it should and stays away where it should not.

#include <fmt/format.h>

#include "formats_testing.h"
#include "scene/check.h"
#include "scene/coincident.h"

namespace etendue::testing {
namespace {

const std::string kQuadUp = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";    // normal +Y
const std::string kQuadDown = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 4 3 2 1\n";  // normal −Y
const std::string kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const std::string kHollow =  // normals inward
    kCube.substr(0, kCube.find("f ")) + "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";

std::string mesh(const std::string& file, const std::string& content = "", const std::string& transform = "") {
  return "<mesh type=\"obj\"><string name=\"filename\" value=\"" + file + "\"/><transform name=\"toWorld\">" +
         transform + "</transform>" + content + "</mesh>\n";
}
const std::string kEmitter = "<emitter type=\"area\"><color name=\"radiance\" value=\"1 1 1\"/></emitter>";
const std::string kGlass = "<bsdf type=\"dielectric\"/>";

std::string check(const std::string& content, const std::string& camera_at = "0.3 0.4 5",
                  const std::string& integrator = "<integrator type=\"path\"/>") {
  TemporaryFolder folder;
  folder.write("up.obj", kQuadUp);
  folder.write("down.obj", kQuadDown);
  folder.write("cube.obj", kCube);
  folder.write("hollow.obj", kHollow);
  folder.write("open.obj", kCube.substr(0, kCube.rfind("f ")));
  folder.write("inward.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n");
  const std::string camera = "<camera type=\"perspective\"><transform name=\"toWorld\"><translate value=\"" +
                             camera_at + "\"/></transform></camera>";
  const std::string file = folder.write("s.xml", "<scene>" + integrator + camera + "\n" + content + "</scene>");
  Diagnostics diagnostics;
  const auto scene = read_scene_file(file, {}, diagnostics);
  EXPECT_TRUE(scene.has_value()) << all_messages(diagnostics);
  if (scene) {
    check_scene_file(*scene, diagnostics);
    check_coincident(*scene, diagnostics);
  }
  return all_messages(diagnostics);
}

void expect_says(const std::string& messages, const char* part) {
  EXPECT_NE(messages.find(part), std::string::npos) << messages;
}

const std::string kLight = "<color name=\"sky_top\" value=\"1 1 1\"/>";

TEST(Check, LightsWithoutExtentNeedLightSampling) {
  const std::string point = "<emitter type=\"point\"><color name=\"power\" value=\"1 1 1\"/></emitter>";
  EXPECT_EQ(check(mesh("up.obj") + point), "");
  EXPECT_EQ(check(mesh("up.obj") + point, "0 0 5", "<integrator type=\"whitted\"/>"), "");
  expect_says(check(mesh("up.obj") + point, "0 0 5", "<integrator type=\"path_mats\"/>"), "so they are dark");
  expect_says(check(mesh("up.obj") + point, "0 0 5", "<integrator type=\"direct_mats\"/>"), "so they are dark");
}

TEST(Check, ASoundSceneIsQuiet) {
  EXPECT_EQ(check(mesh("up.obj") + mesh("down.obj", kEmitter, "<translate value=\"0 3 0\"/>") +
                  mesh("cube.obj", kGlass, "<translate value=\"0 0.5 0\"/>")),
            "");
  EXPECT_EQ(check(mesh("up.obj"), "0 0 5", "<integrator type=\"normals\"/>"), "");
}

TEST(Check, SurfacesThatLieInOneAnother) {
  const char* const kSays = "coincides with a surface of \"up.obj\" of line";
  const auto lift = [](const char* y) { return fmt::format("<translate value=\"0 {} 0\"/>", y); };
  // A rug on the floor; turned about the vertical, so that its edges cross the floor's.
  expect_says(check(kLight + mesh("up.obj") + mesh("up.obj", "", "<rotate angle=\"30\" axis=\"0 1 0\"/>")), kSays);
  expect_says(check(kLight + mesh("up.obj", "", lift("0.1")) + mesh("up.obj", "", lift("0.1"))), kSays);
  // Glass that stands on the floor, and a lamp flush with the floor.
  expect_says(check(kLight + mesh("up.obj") + mesh("cube.obj", kGlass)), kSays);
  expect_says(check(mesh("up.obj") + mesh("up.obj", kEmitter, "<scale value=\"0.3 1 0.3\"/>")), kSays);
  const std::string sphere = "<mesh type=\"sphere\"/>";
  expect_says(check(kLight + sphere + sphere, "0 0 5"), "\"sphere\" coincides with a surface of \"sphere\"");
  // Nobody sees what an opaque block and the floor have in common; neighbours touch along an edge only; a gap is a gap.
  EXPECT_EQ(check(kLight + mesh("up.obj") + mesh("cube.obj")), "");
  EXPECT_EQ(check(kLight + mesh("up.obj") + mesh("up.obj", "", "<translate value=\"2 0 0\"/>")), "");
  EXPECT_EQ(check(kLight + mesh("up.obj") + mesh("up.obj", "", lift("1e-4"))), "");
}

TEST(Check, NoLight) {
  expect_says(check(mesh("up.obj")),
              "s.xml:1:1: the scene has no emitter and a black sky: the image will be black; add a lamp or a sky");
  EXPECT_EQ(check(kLight + mesh("up.obj")), "");
  expect_says(
      check("<mesh type=\"sphere\"><emitter type=\"area\"><color name=\"radiance\" value=\"0 0 0\"/></emitter></mesh>"),
      "no emitter and a black sky");
}

TEST(Check, EmitterFacingAway) {
  const std::string messages =
      check(mesh("up.obj") + mesh("up.obj", kEmitter, "<translate value=\"0 3 0\"/>"), "0 1 5");
  expect_says(messages, "s.xml:3:1: the emitter \"up.obj\" faces away from everything");
  // A camera above sees it.
  EXPECT_EQ(check(mesh("up.obj") + mesh("up.obj", kEmitter, "<translate value=\"0 3 0\"/>"), "0 9 5"), "");
  // A closed box that emits inward lights itself.
  EXPECT_EQ(check(mesh("hollow.obj", kEmitter), "0.5 0.5 0.5").find("faces away"), std::string::npos);
  expect_says(check(mesh("cube.obj", kEmitter), "0.5 0.5 0.5"), "faces away");
}

TEST(Check, CameraInGlass) {
  const std::string sphere = "<mesh type=\"sphere\"><float name=\"radius\" value=\"2\"/>" + kGlass + "</mesh>\n";
  expect_says(check(kLight + sphere, "0 0 1"), "s.xml:1:33: the camera is inside the dielectric \"sphere\" of line 2");
  EXPECT_EQ(check(kLight + sphere, "0 0 3"), "");
  expect_says(check(kLight + mesh("cube.obj", kGlass), "0.5 0.5 0.5"), "inside the dielectric \"cube.obj\"");
  EXPECT_EQ(check(kLight + mesh("cube.obj", kGlass), "1.5 0.5 0.5"), "");
  // In the hollow of a bubble there is air.
  const std::string hollow =
      "<mesh type=\"sphere\"><float name=\"radius\" value=\"1.5\"/><bsdf type=\"dielectric\"><float name=\"intIOR\" "
      "value=\"1\"/>"
      "<float name=\"extIOR\" value=\"1.5\"/></bsdf></mesh>";
  EXPECT_EQ(check(kLight + sphere + hollow, "0 0 1"), "");
  expect_says(check(kLight + sphere + hollow, "0 0 1.7"), "the camera is inside");
}

TEST(Check, NormalsAgainstWinding) {
  expect_says(check(kLight + mesh("inward.obj")),
              "1 of 1 triangles of \"inward.obj\" have vertex normals against their winding");
}

TEST(Check, OpenGlass) {
  expect_says(check(kLight + mesh("open.obj", kGlass)),
              "the dielectric mesh \"open.obj\" is not closed (4 open edges)");
  EXPECT_EQ(check(kLight + mesh("cube.obj", kGlass)), "");
}

TEST(Check, ShapesTooSmallForSinglePrecision) {
  const auto ball = [](const char* radius) {
    return "<mesh type=\"sphere\"><float name=\"radius\" value=\"" + std::string(radius) + "\"/></mesh>\n";
  };
  expect_says(check(kLight + ball("1e6") + ball("0.1")),
              "s.xml:3:1: \"sphere\" is 1e-07 of the scene's size: single precision");
  EXPECT_EQ(check(kLight + ball("1e4") + ball("0.1")), "");
}

TEST(Check, GlassWithoutEffect) {
  expect_says(check(kLight + mesh("cube.obj",
                                  "<bsdf type=\"dielectric\"><float name=\"intIOR\" value=\"1.3\"/><float "
                                  "name=\"extIOR\" value=\"1.3\"/></bsdf>")),
              "the dielectric \"cube.obj\" has no effect: intIOR and extIOR are both 1.3");
}

TEST(Check, MirroredMesh) {
  // The mirror image of a lamp lights the mirror image of what the lamp does; there is nothing to warn of.
  const auto lamp_above = [](const std::string& file, const std::string& scale) {
    return check(mesh("up.obj") + mesh(file, kEmitter, "<scale value=\"" + scale + "\"/><translate value=\"0 3 0\"/>"),
                 "0 1 5");
  };
  EXPECT_EQ(lamp_above("down.obj", "-1 1 1"), "");
  EXPECT_EQ(lamp_above("up.obj", "1 -1 1"), "");
  expect_says(lamp_above("up.obj", "1 1 -1"), "s.xml:3:1: the emitter \"up.obj\" faces away from everything");
  expect_says(lamp_above("down.obj", "1 -1 1"), "s.xml:3:1: the emitter \"down.obj\" faces away from everything");
}

TEST(Check, ParametersWithoutEffect) {
  const auto path = [](const std::string& properties) {
    return "<integrator type=\"path\">" + properties + "</integrator>";
  };
  expect_says(
      check(kLight, "0 0 0", path("<boolean name=\"nee\" value=\"false\"/><boolean name=\"mis\" value=\"true\"/>")),
      "\"mis\" has no effect without nee");
  expect_says(
      check(kLight, "0 0 0", path("<integer name=\"maxDepth\" value=\"3\"/><integer name=\"rrDepth\" value=\"5\"/>")),
      "\"rrDepth\" 5 has no effect");
  expect_says(check(kLight, "0 0 0",
                    path("<integer name=\"maxDepth\" value=\"1000000\"/><integer name=\"rrDepth\" value=\"0\"/>")),
              "may take for ever");
  expect_says(check(kLight + "<boolean name=\"nee\" value=\"true\"/>", "0 0 0", "<integrator type=\"path_mats\"/>"),
              "\"nee\" of <scene> has no effect");
  EXPECT_EQ(check(kLight, "0 0 0", path("<boolean name=\"nee\" value=\"false\"/>")), "");
}

}  // namespace
}  // namespace etendue::testing
