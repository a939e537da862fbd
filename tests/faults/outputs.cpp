/// Several files of one render: one that cannot be written does not cost the others, and none is lost to another.

#include <signal.h>

#include "render_fixture.h"

namespace etendue::faults {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Outputs : public RenderTest {
 protected:
  /// A render that has written its first checkpoint and goes on until it is told to stop.
  static std::vector<std::string> endless(const std::vector<std::string>& more) {
    std::vector<std::string> arguments =
        render({"--spp", "10000000", "--checkpoint-every", "100ms", "--pass-samples", "4"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(Outputs, OneThatCannotBeWrittenDoesNotCostTheOthers) {
  fs::create_directories(folder_ / "gone");
  Process process(endless({"--checkpoint", "ck.exr", "--film", "-o", "gone/a.exr", "-o", "b.exr", "-o", "gone/c.png",
                           "-o", "d.png", "--json"}),
                  folder_);
  ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
  fs::remove_all(folder_ / "gone");
  process.signal(SIGTERM);
  const ProcessResult result = process.wait();
  expect_error(result, 6, "gone/a.exr");
  EXPECT_THAT(result.err, HasSubstr("gone/c.png"));
  EXPECT_THAT(result.out, HasSubstr("\"outputs\": [\n    \"b.exr\",\n    \"d.png\"\n  ]"));
  expect_same("ck.exr", "b.exr");
  EXPECT_TRUE(exists("d.png"));
}

TEST_F(Outputs, ACheckpointThatCannotBeWrittenDoesNotEndTheRender) {
  fs::create_directories(folder_ / "gone");
  Process process(endless({"--checkpoint", "gone/ck.exr", "--film", "-o", "x.exr"}), folder_);
  ASSERT_TRUE(wait_until([&] { return exists("gone/ck.exr"); }));
  fs::remove_all(folder_ / "gone");
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_TRUE(process.is_running());
  process.signal(SIGTERM);
  const ProcessResult result = process.wait();
  expect_error(result, 6, "gone/ck.exr");
  EXPECT_THAT(result.err, HasSubstr("The last checkpoint is kept."));
  expect_ok(render({"--spp", samples_of("x.exr"), "--film", "-o", "one.exr"}));
  expect_same("x.exr", "one.exr");
}

TEST_F(Outputs, APictureOnRequestThatCannotBeWrittenDoesNotEndTheRender) {
  fs::create_directories(folder_ / "gone");
  Process process(endless({"--checkpoint", "ck.exr", "-o", "gone/x.exr", "-o", "y.exr"}), folder_);
  ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
  fs::remove_all(folder_ / "gone");
  process.signal(SIGUSR1);
  ASSERT_TRUE(wait_until([&] { return exists("y.exr"); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_TRUE(process.is_running());
  process.signal(SIGTERM);
  expect_error(process.wait(), 6, "gone/x.exr");
}

TEST_F(Outputs, TwoNamesOfOneFileAreRefused) {
  expect_ok(render({"--spp", "2", "--checkpoint", "z.exr", "-o", "z.png"}));
  fs::create_symlink("z.exr", folder_ / "link.exr");
  fs::create_symlink("later.exr", folder_ / "ahead.exr");
  fs::create_hard_link(folder_ / "z.exr", folder_ / "hard.exr");
  fs::create_directory_symlink(".", folder_ / "here");
  const std::string before = read_text(folder_ / "z.exr");
  const std::vector<std::vector<std::string>> cases = {
      {"--checkpoint", "z.exr", "-o", "z.exr"},
      {"--checkpoint", "z.exr", "-o", "./z.exr"},
      {"--checkpoint", "z.exr", "-o", folder_ / "z.exr"},
      {"--checkpoint", "z.exr", "-o", "link.exr"},
      {"--checkpoint", "link.exr", "-o", "z.exr"},
      {"--checkpoint", "z.exr", "-o", "hard.exr"},
      {"--checkpoint", "z.exr", "-o", "here/z.exr"},
      {"--checkpoint", "new.exr", "-o", "here/./new.exr"},
      {"--checkpoint", "later.exr", "-o", "ahead.exr"},
      {"--checkpoint", "z.exr", "-o", "y.png", "--film", "-o", "z.exr"},
      {"--checkpoint", "cbox-sphere.exr"},  // the name of the picture where none is given
      {"--checkpoint", "heat.exr", "-o", "y.exr", "--heat-map", "heat.exr"},
      {"-o", "y.exr", "--heat-map", "y.exr"},
      {"--resume", "z.exr", "-o", "z.exr"},
      {"--resume", "z.exr", "-o", "hard.exr"}};
  for (const std::vector<std::string>& more : cases) {
    SCOPED_TRACE(testing::PrintToString(more));
    std::vector<std::string> arguments = render({"--spp", "4"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_error(run(arguments), 2, "are the same file");
    EXPECT_TRUE(read_text(folder_ / "z.exr") == before);
  }
  expect_error(run({"merge", "z.exr", "-o", "z.exr", "--picture"}), 2, "are the same file");
  EXPECT_TRUE(read_text(folder_ / "z.exr") == before);
  EXPECT_FALSE(exists("new.exr") || exists("later.exr") || exists("cbox-sphere.exr") || exists("y.exr"));
  // A film may take the place of the film that it goes on from.
  expect_ok(render({"--spp", "4", "--resume", "z.exr", "--film", "-o", "z.exr"}));
  EXPECT_EQ(samples_of("z.exr"), "4");
}

TEST_F(Outputs, ACheckpointReplacesNothingButItsOwn) {
  expect_ok(render({"--spp", "4", "--seed", "1", "--film", "-o", "other.exr"}));
  expect_ok(render({"--spp", "4", "-o", "picture.exr", "-o", "picture.png"}));
  write_text(folder_ / "text", "a text");
  for (const char* name : {"other.exr", "picture.exr", "picture.png", "text"}) {
    const std::string before = read_text(folder_ / name);
    expect_error(run(render({"--spp", "4", "--checkpoint", name, "-o", "x.exr"})), 2, "would replace");
    EXPECT_TRUE(read_text(folder_ / name) == before) << name;
  }
  EXPECT_FALSE(exists("x.exr"));
  write_text(folder_ / "empty", "");  // as mktemp makes it
  expect_ok(render({"--spp", "4", "--checkpoint", "empty", "-o", "x.exr"}));
  EXPECT_EQ(samples_of("empty"), "4");
}

TEST_F(Outputs, AForgottenResumeLosesNothing) {
  expect_ok(render({"--spp", "9", "--checkpoint", "ck.exr", "-o", "x.exr"}));
  const std::string before = read_text(folder_ / "ck.exr");
  // Samples that this run does not want would be lost for ever.
  expect_error(run(render({"--spp", "4", "--checkpoint", "ck.exr", "-o", "y.exr"})), 2, "holds the samples 4:9");
  const ProcessResult result =
      run(render({"--spp", "12", "--pass-samples", "2", "--time", "1ms", "--checkpoint", "ck.exr", "-o", "x.exr"}));
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("'--resume ck.exr' continues from there"));
  EXPECT_TRUE(read_text(folder_ / "ck.exr") == before) << "stopped after 2 samples, it replaced 9";
  expect_ok(render({"--spp", "12", "--checkpoint", "ck.exr", "-o", "x.exr"}));
  EXPECT_EQ(samples_of("ck.exr"), "12");
}

// Another process may have taken the name since the render began.
TEST_F(Outputs, WhatCameToStandAtTheCheckpointsPlaceIsKept) {
  expect_ok(render({"--spp", "4", "--seed", "1", "--film", "-o", "other.exr"}));
  const std::string other = read_text(folder_ / "other.exr");
  Process process(endless({"--checkpoint", "ck.exr", "-o", "x.exr"}), folder_);
  ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
  fs::rename(folder_ / "other.exr", folder_ / "ck.exr");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  process.signal(SIGTERM);
  expect_error(process.wait(), 6, "different seeds");
  EXPECT_TRUE(read_text(folder_ / "ck.exr") == other);
  EXPECT_TRUE(exists("x.exr"));
}

}  // namespace
}  // namespace etendue::faults
