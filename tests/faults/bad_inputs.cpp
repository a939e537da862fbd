#include "bad_inputs.h"

#include <cstdlib>
#include <map>
#include <regex>

#include <gmock/gmock.h>
#include <unistd.h>

namespace etendue::faults {
namespace {

namespace fs = std::filesystem;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
// No limits where sanitizers are at work: their shadow memory takes terabytes of addresses, and they take their time.
const bool kLimited = !kSanitized && std::getenv("ETENDUE_TEST_BINARY") == nullptr;
const std::uint64_t kMemory = kLimited ? std::uint64_t{1} << 30 : 0;
const std::uint64_t kCpuSeconds = kLimited ? 20 : 0;

/// Names, kinds and contents of what a folder holds. Not recursive: that would follow links that lead in circles.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::file_status status = entry.symlink_status();
    const bool readable = fs::is_regular_file(status) && entry.file_size() < (std::uintmax_t{32} << 20);
    all[entry.path().filename().string()] =
        readable ? read_text(entry.path()) : std::to_string(static_cast<int>(status.type()));
  }
  return all;
}

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("etendue-bad-" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

void expect_refused(const BadInput& input) {
  SCOPED_TRACE(input.name);
  const Folder folder;
  for (std::size_t i = 0; i + 1 < input.files.size(); i += 2)
    write_text(folder.path() / input.files[i], input.files[i + 1]);
  if (input.prepare) input.prepare(folder.path());
  const auto before = contents(folder.path());
  const ProcessOptions limits{.environment = {{"NO_COLOR", "1"}},
                              .memory_limit = kMemory,
                              .cpu_seconds_limit = kCpuSeconds,
                              .bound_by_permissions = true};
  const ProcessResult result = etendue(input.arguments, folder.path(), limits);
  EXPECT_EQ(result.code, input.code) << result.err << result.out;
  const std::vector<std::string> errors = result.errors();
  ASSERT_EQ(errors.size(), 1u) << result.err << result.out;
  const std::string sentence = errors.front().substr(std::string_view("error: ").size());
  EXPECT_TRUE(std::regex_search(sentence, std::regex("^" + input.place))) << sentence;
  EXPECT_THAT(sentence, testing::HasSubstr(input.words));
  EXPECT_TRUE(contents(folder.path()) == before) << "the run left or changed a file";
}

std::string scene_with(const std::string& content) {
  return "<scene><integrator type=\"path\"/><camera type=\"perspective\"/>\n" + content + "\n</scene>\n";
}

std::string scene_of_mesh() {
  return scene_with("<mesh type=\"obj\"><string name=\"filename\" value=\"mesh.obj\"/></mesh>");
}

std::vector<std::string> render_scene() {
  return {"render", "scene.xml", "-o", "out.exr", "-o", "out.png"};
}

}  // namespace etendue::faults
