/// The files that scenes name, beside the scene or made by Etendue's build.

#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/nori/named_files.h"
#include "formats_testing.h"

namespace etendue {
namespace {

using testing::all_messages;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::scene_around;

constexpr const char* kOneTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
constexpr const char* kTwoTriangles = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 3 2 4\n";

std::string mesh(const std::string& filename) {
  return "<mesh type=\"obj\"><string name=\"filename\" value=\"" + filename + "\"/></mesh>";
}

/// A scene in one folder; what a build would have made in another one, which ETENDUE_MESHES names.
class NamedFilesTest : public ::testing::Test {
 protected:
  NamedFilesTest() {
    if (const char* before = std::getenv("ETENDUE_MESHES")) before_ = before;
    name_made_folder(build_.path("share/etendue/meshes"));
  }
  ~NamedFilesTest() override { before_ ? name_made_folder(*before_) : unname_made_folder(); }

  static void name_made_folder(const std::string& folder) { ::setenv("ETENDUE_MESHES", folder.c_str(), 1); }
  static void unname_made_folder() { ::unsetenv("ETENDUE_MESHES"); }
  std::string make(const std::string& name, const std::string& content = kOneTriangle) {
    return build_.write("share/etendue/meshes/" + name, content);
  }
  std::optional<SceneFile> read(const std::string& content) {
    diagnostics_ = {};
    return read_scene_file(folder_.write("scene.xml", scene_around(content)), {}, diagnostics_);
  }
  std::size_t triangles(const std::string& content) {
    const auto file = read(content);
    EXPECT_TRUE(file.has_value()) << messages();
    return file ? std::get<TriangleMesh>(std::get<Scene>(*file).shapes.at(0)).triangles.size() : 0;
  }
  std::string messages() const { return all_messages(diagnostics_); }

  testing::TemporaryFolder folder_, build_;
  std::optional<std::string> before_;
  Diagnostics diagnostics_;
};

TEST_F(NamedFilesTest, AMadeFileIsFoundAndItsPlaceIsNotedOnce) {
  const std::string path = make("ball.obj");
  const auto file = read(mesh("etendue:ball.obj") + mesh(" etendue:ball.obj "));
  ASSERT_TRUE(file.has_value()) << messages();
  EXPECT_EQ(diagnostics_.list().size(), 1u) << messages();
  EXPECT_THAT(messages(), HasSubstr(":2:49: \"etendue:ball.obj\" is " + path + "\n"));
  EXPECT_EQ(diagnostics_.list().at(0).severity, Severity::note);
}

TEST_F(NamedFilesTest, ANameWithoutThePrefixIsTheFileBesideTheScene) {
  make("ball.obj", kTwoTriangles);
  folder_.write("ball.obj", kOneTriangle);
  EXPECT_EQ(triangles(mesh("ball.obj")), 1u);
  EXPECT_TRUE(diagnostics_.list().empty()) << messages();
  EXPECT_EQ(triangles(mesh("etendue:ball.obj")), 2u);
}

TEST_F(NamedFilesTest, AMadeFileIsNoSubstituteForAMissingOne) {
  make("ball.obj");
  EXPECT_FALSE(read(mesh("ball.obj")).has_value());
  EXPECT_THAT(messages(), HasSubstr("scene.xml:2:49: mesh " + folder_.path("ball.obj") + ": cannot open the file"));
  EXPECT_THAT(messages(), HasSubstr("; names are relative to the folder of the scene file, and \"etendue:ball.obj\" is "
                                    "the file that Etendue's build makes\n"));
  EXPECT_FALSE(read(mesh("cube.obj")).has_value());
  EXPECT_THAT(messages(), HasSubstr("; names are relative to the folder of the scene file\n"));
}

TEST_F(NamedFilesTest, AFileThatIsNotMadeYetIsAnErrorWithTheCommandThatMakesIt) {
  build_.write("CMakeCache.txt", "");
  make("sphere.obj");
  const std::string build = std::filesystem::path(build_.path("CMakeCache.txt")).parent_path().string();
  const std::string command = "; 'cmake --build " + build + " --target scenes' makes";
  for (const std::string& content :
       {mesh("etendue:bust.obj"),
        std::string("<emitter type=\"envmap\"><string name=\"filename\" value=\"etendue:bust.obj\"/></emitter>"),
        std::string("<mesh type=\"sphere\"><bsdf type=\"diffuse\"><texture name=\"albedo\" type=\"bitmap\"><string "
                    "name=\"filename\" value=\"etendue:bust.obj\"/></texture></bsdf></mesh>")}) {
    EXPECT_FALSE(read(content).has_value());
    EXPECT_THAT(messages(), HasSubstr(build_.path("share/etendue/meshes/bust.obj") + ": cannot open"));
    EXPECT_THAT(messages(), HasSubstr(command));
    EXPECT_THAT(messages(), Not(HasSubstr("did you mean")));
  }
  EXPECT_FALSE(read(mesh("etendue:spere.obj")).has_value());
  EXPECT_THAT(messages(), HasSubstr(command));
  EXPECT_THAT(messages(), HasSubstr("; did you mean \"etendue:sphere.obj\"?"));
}

TEST_F(NamedFilesTest, OutsideABuildTheErrorNamesTheVariable) {
  EXPECT_FALSE(read(mesh("etendue:bust.obj")).has_value());
  EXPECT_THAT(messages(), HasSubstr("; set ETENDUE_MESHES to share/etendue/meshes of an installation"));
}

TEST_F(NamedFilesTest, AMadeFileIsInThatFolderAlone) {
  build_.write("share/secret.obj", kOneTriangle);
  make("folder/ball.obj");
  make(".hidden.obj");
  for (const std::string name :
       {"", "../../secret.obj", "folder/ball.obj", "..\\secret.obj", "..", ".hidden.obj", "/etc/passwd"}) {
    EXPECT_FALSE(read(mesh("etendue:" + name)).has_value()) << name;
    EXPECT_EQ(diagnostics_.list().size(), 1u) << messages();
    EXPECT_THAT(messages(), HasSubstr("cannot follow \"etendue:\"")) << name;
  }
}

TEST_F(NamedFilesTest, WithoutTheVariableTheFolderIsFoundFromTheProgram) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path();
  for (const bool empty : {false, true}) {
    empty ? name_made_folder("") : unname_made_folder();
    EXPECT_EQ(made_files_folder(), program / "share/etendue/meshes");
  }
}

}  // namespace
}  // namespace etendue
