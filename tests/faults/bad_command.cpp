/// Command lines that ask for what cannot be: code 2 for the words, 6 for the files they name.

#include <sys/stat.h>
#include <unistd.h>

#include <fmt/core.h>

#include "bad_inputs.h"

namespace etendue::faults {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> render_with(const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"render", "scene.xml", "--device", "reference",
                                        "--size", "8x6",       "-o",       "out.exr"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(BadCommand, Overrides) {
  const std::vector<std::pair<std::string, std::string>> overrides = {
      {"camera.width", "has no '='"},
      {"", "has no '='"},
      {"=", "has no property \"\""},
      {"=5", "has no property \"\""},
      {"camera.width=", "not an integer"},
      {"camera.width=abc", "not an integer"},
      {"camera.width=0x10", "not an integer"},
      {"camera.width=1.5", "not an integer"},
      {"camera.width=0", "out of range"},
      {"camera.width=65537", "out of range"},
      {"camera.width=99999999999999999999", "too large"},
      {"camera.fov=nan", "not a finite number"},
      {"camera.fov=180", "out of range"},
      {"camera.fov=1e999", "too large"},
      {"camera.widht=5", "did you mean \"camera.width\"?"},
      {"camera=5", "has no property \"camera\""},
      {"width=5", "has no property \"width\""},
      {"camera.toWorld=1", "has no property \"camera.toWorld\""},
      {"mesh.radius=1", "has no property \"mesh.radius\""},
      {"camera..width=5", "has no property"},
      {"Camera.width=5", "did you mean"},
      {"integrator.nee=2", "write true or false"},
      {"integrator.maxDepth=0", "out of range"},
      {"sampler.sampleCount=-1", "out of range"},
      {"sampler.sampleCount=4294967296", "out of range"},
      {"scene.sky_top=1 2", "expected 3 numbers"},
      {"scene.sky_top=-1 0 0", "out of range"},
      {"scene.sky_top=1;2;3", "not a number"},
      {"rfilter.width=1", "has no property"},
      {std::string(100000, 'a') + "=1", "has no property"}};
  for (const auto& [text, words] : overrides) {
    expect_refused(
        {"-D " + text.substr(0, 40), {"scene.xml", scene_with("")}, render_with({"-D", text}), 2, "", words, {}});
  }
}

TEST(BadCommand, Values) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> options = {
      {{"--size", "0x5"}, "WIDTHxHEIGHT"},
      {{"--size", "5"}, "WIDTHxHEIGHT"},
      {{"--size", "5x"}, "WIDTHxHEIGHT"},
      {{"--size", "-5x5"}, "WIDTHxHEIGHT"},
      {{"--size", "65537x1"}, "WIDTHxHEIGHT"},
      {{"--size", "1e3x5"}, "WIDTHxHEIGHT"},
      {{"--size", "65536x65536"}, "at most 67108864"},
      {{"--samples", "5:5"}, "range A:B"},
      {{"--samples", "6:5"}, "range A:B"},
      {{"--samples", "0:4294967296"}, "range A:B"},
      {{"--samples", "-1:5"}, "range A:B"},
      {{"--samples", "0"}, "range A:B"},
      {{"--samples", "0:64", "--spp", "32"}, "inside 0:N"},
      {{"--time", "10"}, "duration"},
      {{"--time", "0s"}, "duration"},
      {{"--time", "-1s"}, "duration"},
      {{"--time", "1e9d"}, "duration"},
      {{"--time", "nans"}, "duration"},
      {{"--until-error", "0"}, "fraction"},
      {{"--until-error", "100%"}, "fraction"},
      {{"--checkpoint-every", "5s"}, "--checkpoint FILE"},
      {{"-o", "picture.jpg"}, "neither in .exr nor in .png"},
      {{"-o", ""}, "neither in .exr nor in .png"},
      {{"-o", "/dev/null"}, "neither in .exr nor in .png"},
      {{"--traversal", "query"}, "has its own tree"},
      {{"--checkpoint", "scene.xml"}, "would replace a file that is not a film"}};
  for (const auto& [arguments, words] : options) {
    std::vector<std::string> all = {"render", "scene.xml", "--device", "reference"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    expect_refused({arguments[0] + " " + arguments[1], {"scene.xml", scene_with("")}, all, 2, "", words, {}});
  }
}

/// What the parser of options refuses itself: code 2, and something on stderr that names the option.
TEST(BadCommand, WordsTheParserRefuses) {
  const std::vector<std::vector<std::string>> lines = {{},
                                                       {"rendr", "scene.xml"},
                                                       {"render"},
                                                       {"render", "a.xml", "b.xml"},
                                                       {"render", "scene.xml", "--spp", "0"},
                                                       {"render", "scene.xml", "--spp", "4294967296"},
                                                       {"render", "scene.xml", "--spp", "-5"},
                                                       {"render", "scene.xml", "--spp", "abc"},
                                                       {"render", "scene.xml", "--spp", "1.5"},
                                                       {"render", "scene.xml", "--seed", "-1"},
                                                       {"render", "scene.xml", "--seed", "4294967296"},
                                                       {"render", "scene.xml", "--threads", "-1"},
                                                       {"render", "scene.xml", "--threads", "100000"},
                                                       {"render", "scene.xml", "--traversal", "fast"},
                                                       {"render", "scene.xml", "--stats", "--traversal", "query"},
                                                       {"render", "scene.xml", "--colour"},
                                                       {"render", "scene.xml", "-o"},
                                                       {"compare", "a.exr"},
                                                       {"merge", "a.exr"},
                                                       {"check"}};
  for (const std::vector<std::string>& line : lines) {
    const ProcessResult result = etendue(line, fs::temp_directory_path());
    EXPECT_EQ(result.code, 2) << testing::PrintToString(line) << result.err;
    EXPECT_FALSE(result.err.empty()) << testing::PrintToString(line);
  }
}

TEST(BadCommand, PlacesThatCannotBeWritten) {
  const std::vector<std::pair<std::string, std::function<void(const fs::path&)>>> places = {
      {"none/out.exr", {}},
      {"scene.xml/out.exr", {}},
      {"folder.exr", [](const fs::path& p) { fs::create_directory(p / "folder.exr"); }},
      {"fifo.exr", [](const fs::path& p) { ASSERT_EQ(mkfifo((p / "fifo.exr").c_str(), 0600), 0); }},
      {"loop.exr", [](const fs::path& p) { fs::create_symlink("loop.exr", p / "loop.exr"); }},
      {"device.exr", [](const fs::path& p) { fs::create_symlink(full_device(), p / "device.exr"); }},
      {"away.exr", [](const fs::path& p) { fs::create_symlink("none/away.exr", p / "away.exr"); }},
      {std::string(300, 'a') + ".exr", {}},
      {std::string(5000, 'a') + "/a.exr", {}},
      {"/proc/a.exr", {}}};
  for (const auto& [path, prepare] : places) {
    const std::string place = path.size() > 100 ? "a+" : path;
    expect_refused({"-o " + place, {"scene.xml", scene_with("")}, render_with({"-o", path}), 6, "", "", prepare});
    expect_refused({"--checkpoint " + place,
                    {"scene.xml", scene_with("")},
                    render_with({"--checkpoint", path}),
                    6,
                    "",
                    "",
                    prepare});
  }
}

/// Results that nobody can receive are an error, not a success.
TEST(BadCommand, AFullDiskUnderTheResults) {
  const std::string binary = ETENDUE_BINARY;
  for (const std::string command : {"devices", "check " SCENES_DIR "/cbox-sphere.xml --json", "--help"}) {
    const int status =
        std::system(fmt::format("{} {} > {} 2> /dev/null", binary, command, full_device().string()).c_str());
    EXPECT_EQ(WEXITSTATUS(status), 6) << command;
  }
}

}  // namespace
}  // namespace etendue::faults
