/// Devices that fail and files that cannot be written: the right exit code, one sentence, nothing half-written.

#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "private_mount.h"
#include "render_fixture.h"

namespace etendue::faults {
namespace {

class DeviceFaults : public RenderTest {
 protected:
  static std::size_t count(const std::string& text, const std::string& word) {
    std::size_t n = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
    return n;
  }
  // A checkpoint of 4 samples that the faulty run goes on from, and what it would replace.
  void prepare(const std::string& device = "auto") {
    expect_ok(render({"--spp", "4", "--checkpoint", "ck.exr", "-o", "first.png", "--device", device}));
    write_text(folder_ / "x.exr", "old");
    checkpoint_ = read_text(folder_ / "ck.exr");
  }
  void expect_untouched() const {
    EXPECT_EQ(read_text(folder_ / "x.exr"), "old");
    EXPECT_TRUE(read_text(folder_ / "ck.exr") == checkpoint_) << "the checkpoint changed";
  }
  std::string checkpoint_;
};

TEST_F(DeviceFaults, ALostDeviceIsReplacedAndTheBytesAreTheSame) {
  expect_ok(render({"--spp", "300", "--film", "-o", "one.exr"}));
  // Short passes and rounds: something is home when the device is lost.
  const ProcessResult result = run(render({"--spp", "300", "--film", "-o", "two.exr", "--checkpoint", "ck.exr",
                                           "--checkpoint-every", "1ms", "--pass-samples", "2"}),
                                   fault("lost", 20, "2"));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(count(result.err, "Reopening the device"), 2u) << result.err;
  expect_same("one.exr", "two.exr");
}

// Each is closed and opened by a thread of its own while no other holds the Vulkan instance.
TEST_F(DeviceFaults, DevicesThatAreLostTogetherAreReplacedTogether) {
  expect_ok(render({"--spp", "300", "--film", "-o", "one.exr"}));
  const ProcessResult result =
      run(render({"--spp", "300", "--film", "-o", "two.exr", "--pass-samples", "2", "--device", "0,0"}),
          fault("lost", 20, "2"));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(count(result.err, "Reopening the device"), 2u) << result.err;
  expect_same("one.exr", "two.exr");
}

TEST_F(DeviceFaults, ADeviceThatIsLostAgainAndAgainEndsTheRender) {
  prepare();
  const ProcessResult result =
      run(render({"--spp", "300", "--film", "-o", "x.exr", "--checkpoint", "ck.exr", "--resume", "ck.exr"}),
          fault("lost", 0));
  expect_error(result, 5, "VK_ERROR_DEVICE_LOST");
  EXPECT_EQ(count(result.err, "Reopening the device"), 3u) << result.err;
  expect_untouched();
}

TEST_F(DeviceFaults, WhatWasDeliveredBeforeTheLossIsInTheCheckpoint) {
  write_text(folder_ / "x.exr", "old");
  const ProcessResult result = run(render({"--spp", "100000000", "-o", "x.exr", "--checkpoint", "ck.exr",
                                           "--checkpoint-every", "1ms", "--pass-samples", "1"}),
                                   fault("lost", 30));
  expect_error(result, 5, "VK_ERROR_DEVICE_LOST");
  EXPECT_EQ(read_text(folder_ / "x.exr"), "old");
  expect_ok(render({"--spp", samples_of("ck.exr"), "--film", "-o", "one.exr"}));
  expect_same("one.exr", "ck.exr");
}

TEST_F(DeviceFaults, ExhaustedMemoryIsNotTriedAgain) {
  prepare();
  const ProcessResult result =
      run(render({"--spp", "300", "-o", "x.exr", "--checkpoint", "ck.exr", "--resume", "ck.exr"}), fault("memory", 3));
  expect_error(result, 5, "VK_ERROR_OUT_OF_DEVICE_MEMORY");
  EXPECT_EQ(count(result.err, "Reopening"), 0u) << result.err;
  expect_untouched();
}

// cbox-sphere.xml has 34 primitives, so a tree; 640 × 480 pixels take 40 MB of film.
TEST_F(DeviceFaults, LimitsAreNamedBeforeAnythingIsUploaded) {
  struct Limit {
    std::map<std::string, std::string> environment;
    const char* words;
  };
  const Limit limits[] = {
      {{{"ETENDUE_FAULT_TEXELS", "20"}, {"ETENDUE_FAULT_RANGE", "500"}},
       "reads at most 20 texels of 16 bytes (maxTexelBufferElements) or 500 bytes (maxStorageBufferRange)"},
      {{{"ETENDUE_FAULT_RANGE", "4096"}}, "needs 8192 bytes in one binding, but"},
      {{{"ETENDUE_FAULT_HEAP", "1000000"}}, "of device memory, but"},
      {{{"ETENDUE_FAULT_ALLOCATION", "100"}}, "(maxMemoryAllocationSize); use coarser meshes"}};
  for (const Limit& limit : limits) {
    ProcessOptions options = fault("limits", 0);
    options.environment.insert(limit.environment.begin(), limit.environment.end());
    expect_error(run({"render", kScene, "--size", "640x480", "--spp", "1", "-o", "x.exr"}, options), 5, limit.words);
    EXPECT_FALSE(exists("x.exr"));
  }
}

TEST_F(DeviceFaults, DispatchesKeepToTheWorkgroupsThereMayBe) {
  const auto render = [&](const char* groups, const char* out) {
    ProcessOptions options = fault("limits", 0);
    options.environment["ETENDUE_FAULT_GROUPS"] = groups;
    return run({"render", kScene, "--size", "100x75", "--spp", "3", "--film", "-o", out}, options);
  };
  EXPECT_EQ(render("65535", "many.exr").code, 0);
  const auto few = render("5", "few.exr");
  EXPECT_EQ(few.code, 0) << few.err;
  expect_same("many.exr", "few.exr");
}

// What every Vulkan device can bind suffices, and 8 storage buffers where tables are too long for texel buffers.
TEST_F(DeviceFaults, FewBindingsSuffice) {
  const auto with = [&](const char* buffers, const char* images, const char* texels) {
    ProcessOptions options = fault("limits", 0);
    options.environment["ETENDUE_FAULT_BUFFERS"] = buffers;
    options.environment["ETENDUE_FAULT_IMAGES"] = images;
    options.environment["ETENDUE_FAULT_TEXELS"] = texels;
    return run({"render", kScene, "--size", "40x30", "--spp", "1", "--film", "-o", "x.exr"}, options);
  };
  EXPECT_EQ(with("4", "16", "65536").code, 0) << with("4", "16", "65536").err;
  EXPECT_EQ(with("8", "16", "20").code, 0) << with("8", "16", "20").err;
  expect_error(with("3", "16", "65536"), 4, "gives a kernel 3 storage buffers (maxPerStageDescriptorStorageBuffers)");
  expect_error(with("8", "2", "65536"), 4, "gives a kernel 2 texel buffers (maxPerStageDescriptorSampledImages)");
  expect_error(with("4", "16", "20"), 5, "and for the latter it gives a kernel 4 storage buffers");
}

TEST_F(DeviceFaults, ADispatchThatNeverEndsEndsTheProcess) {
  prepare();
  for (const char* device : {"0", "0,0"}) {
    Process process(render({"--spp", "300", "-o", "x.exr", "--checkpoint", "ck.exr", "--resume", "ck.exr",
                            "--device-timeout", "2s", "--device", device}),
                    folder_, fault("hang", 0));
    const ProcessResult result = process.wait(60.0);
    expect_error(result, 5, "did not finish within 2 s");
    EXPECT_EQ(count(result.err, "Reopening"), 0u) << result.err;
    expect_untouched();
  }
}

TEST_F(DeviceFaults, AHangLosesNothingThatWasDelivered) {
  write_text(folder_ / "x.exr", "old");
  Process process(render({"--spp", "100000000", "-o", "x.exr", "--checkpoint", "ck.exr", "--checkpoint-every", "1ms",
                          "--device-timeout", "2s", "--pass-samples", "1"}),
                  folder_, fault("hang", 30));
  expect_error(process.wait(60.0), 5, "did not finish");
  EXPECT_EQ(read_text(folder_ / "x.exr"), "old");
  expect_ok(render({"--spp", samples_of("ck.exr"), "--film", "-o", "one.exr"}));
  expect_same("one.exr", "ck.exr");
}

class FileFaults : public DeviceFaults {
 protected:
  // A tmpfs of a few pages at folder_/name; false where we may not mount.
  bool mount_small(const std::string& name) {
    std::filesystem::create_directories(folder_ / name);
    mounted_ = folder_ / name;
    if (mount_tmpfs(mounted_, "size=64k")) return true;
    mounted_.clear();
    return false;
  }
  void TearDown() override {
    if (!mounted_.empty()) umount2(mounted_.c_str(), MNT_DETACH);
    RenderTest::TearDown();
  }
  static void expect_no_leftovers(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      EXPECT_FALSE(entry.path().extension() == ".tmp") << entry.path();
    }
  }
  // Renders of hours into folder_/locked, which end at once.
  void expect_refused_at_once(const std::string& words) const {
    const ProcessOptions bound{.bound_by_permissions = true};
    const auto start = std::chrono::steady_clock::now();
    expect_error(run(render({"--spp", "10000000", "-o", "locked/x.exr"}), bound), 6, words);
    expect_error(run(render({"--spp", "10000000", "--checkpoint", "locked/ck.exr", "-o", "x.exr"}), bound), 6, words);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
    EXPECT_EQ(read_text(folder_ / "locked/x.exr"), "old");
  }
  std::filesystem::path mounted_;
};

TEST_F(FileFaults, AFullDiskLeavesTheTarget) {
  if (!mount_small("full")) GTEST_SKIP() << "mounting a tmpfs is not allowed here: " << std::strerror(errno);
  write_text(mounted_ / "x.exr", "old");
  expect_error(run({"render", kScene, "--size", "160x120", "--spp", "2", "--force", "-o", "full/x.exr"}), 6,
               "No space left");
  EXPECT_EQ(read_text(mounted_ / "x.exr"), "old");
  expect_no_leftovers(mounted_);
}

TEST_F(FileFaults, AFullDiskUnderTheCheckpointKeepsTheLastOne) {
  if (!mount_small("full")) GTEST_SKIP() << "mounting a tmpfs is not allowed here: " << std::strerror(errno);
  // A film that just fits, and no room for a second one beside it.
  expect_ok({"render", kScene, "--size", "16x16", "--spp", "4", "--checkpoint", "full/ck.exr", "-o", "first.png"});
  const std::string before = read_text(mounted_ / "ck.exr");
  write_text(mounted_ / "ballast", std::string(40000, 'x'));
  write_text(folder_ / "x.exr", "old");
  const ProcessResult result = run({"render", kScene, "--size", "16x16", "--spp", "4000", "--checkpoint", "full/ck.exr",
                                    "--checkpoint-every", "50ms", "--resume", "full/ck.exr", "--force", "-o", "x.exr"});
  expect_error(result, 6, "No space left");
  EXPECT_TRUE(before == read_text(mounted_ / "ck.exr"));
  EXPECT_NE(read_text(folder_ / "x.exr"), "old");  // the finished picture is not thrown away
  expect_no_leftovers(mounted_);
}

TEST_F(FileFaults, AReadOnlyFolderIsReportedBeforeTheRender) {
  using std::filesystem::perms;
  std::filesystem::create_directories(folder_ / "locked");
  write_text(folder_ / "locked/x.exr", "old");
  std::filesystem::permissions(folder_ / "locked", perms::owner_read | perms::owner_exec);
  expect_refused_at_once("Permission denied");
  std::filesystem::permissions(folder_ / "locked", perms::owner_all);
}

TEST_F(FileFaults, AReadOnlyFileSystemIsReportedBeforeTheRender) {
  if (!mount_small("locked")) GTEST_SKIP() << "mounting a tmpfs is not allowed here: " << std::strerror(errno);
  write_text(mounted_ / "x.exr", "old");
  ASSERT_EQ(mount("tmpfs", mounted_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "size=64k"), 0);
  expect_refused_at_once("Read-only file system");
}

TEST_F(FileFaults, AFileSizeLimitIsAFileError) {
  const ProcessOptions limit{.file_size_limit = 4096};
  // A driver whose memory is a file must be refused in words; then the reference writes.
  const ProcessResult tried = run(render({"--spp", "1", "-o", "tried.png"}), limit);
  const std::string device = tried.code == 4 ? "reference" : "auto";
  if (tried.code == 4) expect_error(tried, 4, "keeps its memory in files, and a file may have 4096 bytes here");
  prepare(device);
  expect_error(run(render({"--spp", "4", "-o", "x.exr", "--device", device}), limit), 6, "File too large");
  expect_error(
      run(render({"--spp", "9", "--checkpoint", "ck.exr", "--resume", "ck.exr", "-o", "x.exr", "--device", device}),
          limit),
      6, "File too large");
  expect_untouched();
  expect_no_leftovers(folder_);
}

TEST_F(FileFaults, AFolderThatVanishesIsAFileErrorAndTheCheckpointIsWhole) {
  std::filesystem::create_directories(folder_ / "gone");
  Process process(render({"--spp", "10000000", "--checkpoint", "ck.exr", "--checkpoint-every", "100ms",
                          "--pass-samples", "4", "-o", "gone/x.exr"}),
                  folder_);
  ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
  std::filesystem::remove_all(folder_ / "gone");
  process.signal(SIGTERM);
  expect_error(process.wait(), 6, "gone/x.exr");
  expect_ok(render({"--spp", samples_of("ck.exr"), "--film", "-o", "one.exr"}));
  expect_same("one.exr", "ck.exr");
}

TEST_F(FileFaults, NothingIsWrittenBesideTheScene) {
  std::filesystem::create_directories(folder_ / "scene");
  std::filesystem::copy(SCENES_DIR "/cbox-sphere.xml", folder_ / "scene");
  std::filesystem::create_directories(folder_ / "scene/meshes");
  for (const auto& entry : std::filesystem::directory_iterator(SCENES_DIR "/meshes")) {
    if (entry.path().filename().string().starts_with("cbox-"))
      std::filesystem::copy(entry.path(), folder_ / "scene/meshes");
  }
  const auto list = [&] {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "scene"))
      names.push_back(entry.path());
    std::sort(names.begin(), names.end());
    return names;
  };
  const auto before = list();
  expect_ok({"render", "scene/cbox-sphere.xml", "--size", "8x8", "--spp", "2"});
  EXPECT_EQ(list(), before);
  EXPECT_TRUE(exists("cbox-sphere.exr") && exists("cbox-sphere.png"));
}

}  // namespace
}  // namespace etendue::faults
