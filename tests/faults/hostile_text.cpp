/// Names and texts that would write to the terminal, are not UTF-8, or never end: in file names, scenes and headers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "process.h"

namespace etendue::faults {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

/// An escape sequence, a bell, a new line that looks like an error, a byte that is not UTF-8, a C1 control character.
const std::string kEvil = "e\x1b[31m\x07\nerror: fake\xff\xc2\x9bz";

/// Bytes that move the cursor or are not UTF-8; newlines are no matter here.
bool is_clean(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if ((c < 0x20 && c != '\n') || c == 0x7f || c == 0xff) return false;
    if (c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0) return false;
  }
  return true;
}

class HostileText : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("etendue-hostile-" + std::to_string(getpid()) + "-" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
    fs::copy_file(SCENES_DIR "/ttest-bsdfs.xml", folder_ / (kEvil + "-t.xml"));
    fs::copy_file(SCENES_DIR "/chi2-bsdfs.xml", folder_ / (kEvil + "-c.xml"));
    write_text(folder_ / (kEvil + ".xml"), R"(<scene><integrator type="path"/>
      <camera type="perspective"><integer name="width" value="4"/><integer name="height" value="3"/></camera>
      <color name="sky_top" value="1, 1, 1"/>
      <mesh type="sphere"><point name="center" value="0, 0, 5"/></mesh></scene>)");
  }
  void TearDown() override { fs::remove_all(folder_); }

  ProcessResult run(const std::vector<std::string>& arguments) const {
    const ProcessResult result = etendue(arguments, folder_);
    EXPECT_TRUE(is_clean(result.out)) << testing::PrintToString(result.out);
    EXPECT_TRUE(is_clean(result.err)) << testing::PrintToString(result.err);
    EXPECT_THAT(result.out + result.err, Not(HasSubstr("\nerror: fake")));
    EXPECT_NE(result.code, 70) << result.err;
    return result;
  }
  static void expect_json(const std::string& text, const std::vector<std::string>& arguments) {
    EXPECT_FALSE(nlohmann::json::parse(text, nullptr, false).is_discarded())
        << testing::PrintToString(arguments) << '\n'
        << testing::PrintToString(text);
  }
  fs::path folder_;
};

TEST_F(HostileText, EveryCommandPrintsCleanTextAndValidJson) {
  const std::string scene = kEvil + ".xml", film = kEvil + ".exr", other = kEvil + "2.exr";
  const std::vector<std::string> device = {"--device", "reference"};
  const std::vector<std::vector<std::string>> commands = {
      {"render", scene, "--device", "reference", "--samples", "0:16", "-o", film},
      {"render", scene, "--device", "reference", "--samples", "16:32", "-o", other},
      {"render", scene, "--device", "reference", "--samples", "0:8", "-o", film},  // refused
      {"merge", film, other, "-o", kEvil + "3.exr"},
      {"merge", film, film, "-o", kEvil + "4.exr"},  // refused
      {"check", scene},
      {"check", scene, kEvil + "-missing.xml"},
      {"explain", scene, "--device", "reference", "--pixel", "1,1"},
      {"ttest", kEvil + "-t.xml", "--device", "reference", "--samples", "1000"},
      {"chi2", kEvil + "-c.xml", "--device", "reference", "--samples", "1000"}};
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(testing::PrintToString(command));
    run(command);
    std::vector<std::string> json = command;
    json.emplace_back("--json");
    if (command[0] == "render" || command[0] == "merge") json.emplace_back("--force");
    const ProcessResult result = run(json);
    if (result.code == 0 || !result.out.empty()) expect_json(result.out, json);
  }
}

TEST_F(HostileText, ReportsAreValidToo) {
  const std::string scene = kEvil + ".xml";
  run({"render", scene, "--device", "reference", "--spp", "16", "-o", kEvil + ".exr"});
  run({"render", scene, "--device", "reference", "--spp", "16", "--seed", "1", "-o", kEvil + "2.exr"});
  const std::vector<std::string> command = {"compare", kEvil + ".exr", kEvil + "2.exr", "--json=r.json",
                                            "--junit", "r.xml",        "--html",        "r.html"};
  run(command);
  expect_json(read_text(folder_ / "r.json"), command);
  for (const char* name : {"r.json", "r.xml", "r.html"}) {
    const std::string text = read_text(folder_ / name);
    EXPECT_FALSE(text.empty());
    EXPECT_TRUE(is_clean(text)) << name;
  }
}

TEST_F(HostileText, NamesInScenesAndHeadersAreCut) {
  const std::string name =
      "\xc2\x9b"
      "31m" +
      std::string(100000, 'x');
  write_text(folder_ / "long.xml", "<scene><mesh type=\"obj\"><string name=\"filename\" value=\"" + name +
                                       ".obj\"/></mesh><" + name + "/></scene>");
  for (const std::string command : {"check", "render"}) {
    const ProcessResult result = run({command, "long.xml"});
    EXPECT_NE(result.code, 0);
    EXPECT_LT(result.out.size() + result.err.size(), 3000u);
  }
  // A film whose header says more than fits on a screen.
  run({"render", kEvil + ".xml", "--device", "reference", "--film", "--spp", "2", "-o", "a.exr"});
  std::string bytes = read_text(folder_ / "a.exr");
  const std::string head = std::string("etendue.version\0string\0", 23);
  const std::size_t at = bytes.find(head);
  ASSERT_NE(at, std::string::npos);
  const std::size_t old_size = static_cast<unsigned char>(bytes[at + head.size()]);
  const std::string value = "\x1b[2J" + std::string(60000, 'v');
  std::string size;
  for (int i = 0; i < 4; ++i) size += static_cast<char>(value.size() >> (8 * i));
  bytes.replace(at + head.size(), 4 + old_size, size + value);
  write_text(folder_ / "b.exr", bytes);
  const ProcessResult result = run({"merge", "a.exr", "b.exr", "-o", "m.exr"});
  EXPECT_EQ(result.code, 6);
  EXPECT_THAT(result.err, HasSubstr("different versions"));
  EXPECT_LT(result.err.size(), 1000u);
}

}  // namespace
}  // namespace etendue::faults
