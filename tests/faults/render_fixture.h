#pragma once
/// What the tests of pieces, kills and faults share: a folder of their own and a small render.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include <unistd.h>

#include "process.h"

namespace etendue::faults {

class RenderTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("etendue-" + std::to_string(getpid()) + "-" +
                                                        testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    if (etendue({"render", kScene, "--size", "8x8", "--spp", "1", "-o", "probe.png", "-q"}, folder_).code == 4) {
      GTEST_SKIP() << "no Vulkan device";
    }
    std::filesystem::remove(folder_ / "probe.png");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Arguments of a small render that replaces whatever is there; `more` is appended.
  static std::vector<std::string> render(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"render", kScene, "--size", "40x30", "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  ProcessResult run(const std::vector<std::string>& arguments, const ProcessOptions& options = {}) const {
    return etendue(arguments, folder_, options);
  }
  void expect_ok(const std::vector<std::string>& arguments, const ProcessOptions& options = {}) const {
    const ProcessResult result = run(arguments, options);
    EXPECT_EQ(result.code, 0) << result.err;
  }
  /// Ends with this code and one sentence on stderr that contains `words`.
  static void expect_error(const ProcessResult& result, int code, const std::string& words) {
    EXPECT_EQ(result.code, code) << result.err;
    ASSERT_EQ(result.errors().size(), 1u) << result.err;
    EXPECT_THAT(result.errors().front(), testing::HasSubstr(words));
  }
  /// What makes the device fail, see fault_layer.cpp.
  static ProcessOptions fault(const std::string& kind, int after, const std::string& times = "1000000") {
    return {.environment = {{"VK_LAYER_PATH", FAULT_LAYER_FOLDER},
                            {"VK_INSTANCE_LAYERS", "VK_LAYER_ETENDUE_fault"},
                            {"ETENDUE_FAULT", kind},
                            {"ETENDUE_FAULT_AFTER", std::to_string(after)},
                            {"ETENDUE_FAULT_TIMES", times}}};
  }
  void expect_same(const std::string& a, const std::string& b) const {
    const std::string bytes = read_text(folder_ / a);
    EXPECT_FALSE(bytes.empty()) << a;
    EXPECT_TRUE(bytes == read_text(folder_ / b)) << a << " and " << b << " differ";
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  /// How many samples per pixel a film holds, by what merge says of it.
  std::string samples_of(const std::string& film) const;

  static constexpr const char* kScene = SCENES_DIR "/cbox-sphere.xml";
  std::filesystem::path folder_;
};

}  // namespace etendue::faults
