/// What stands where a picture is to go: replaced when it is worth no more, else kept.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include <unistd.h>

#include "process.h"

namespace etendue::faults {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// Renders of a few pixels by the reference, so that no device is needed.
class Overwrite : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("etendue-overwrite-" + std::to_string(getpid()) + "-" +
                                           testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  ProcessResult render(const std::vector<std::string>& more, const std::string& scene = "cbox-sphere") const {
    const auto says = [&](const char* option) { return std::ranges::find(more, option) != more.end(); };
    std::vector<std::string> arguments = {"render", SCENES_DIR "/" + scene + ".xml"};
    if (!says("--device")) arguments.insert(arguments.end(), {"--device", "reference"});
    if (!says("--size")) arguments.insert(arguments.end(), {"--size", "8x6"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return etendue(arguments, folder_);
  }
  void expect_ok(const std::vector<std::string>& more) const {
    const ProcessResult result = render(more);
    EXPECT_EQ(result.code, 0) << result.err;
  }
  /// Ends with code 6 and one sentence that holds `words`; the file keeps its bytes.
  void expect_kept(const std::string& file, const std::vector<std::string>& more, const std::string& words) const {
    SCOPED_TRACE(testing::PrintToString(more));
    const std::string before = read_text(folder_ / file);
    const ProcessResult result = render(more);
    EXPECT_EQ(result.code, 6) << result.err;
    ASSERT_EQ(result.errors().size(), 1u) << result.err;
    EXPECT_THAT(result.errors().front(), HasSubstr(words));
    EXPECT_THAT(result.errors().front(), HasSubstr(file));
    EXPECT_TRUE(read_text(folder_ / file) == before);
  }
  bool changes(const std::string& file, const std::vector<std::string>& more) const {
    const std::string before = read_text(folder_ / file);
    expect_ok(more);
    return read_text(folder_ / file) != before;
  }
  fs::path folder_;
};

TEST_F(Overwrite, APictureOfNoMoreSamplesIsReplacedAndNamed) {
  for (const std::string name : {"a.exr", "a.png"}) {
    expect_ok({"--spp", "4", "-o", name});
    const ProcessResult again = render({"--spp", "4", "--seed", "1", "-o", name});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_THAT(
        again.err,
        HasSubstr(name + " exists, a picture of 8x6 pixels and 4 samples each, of seed 0, and will be replaced"));
    EXPECT_TRUE(changes(name, {"--spp", "8", "-o", name}));
    EXPECT_TRUE(changes(name, {"--spp", "2", "--size", "16x16", "-o", name}));  // other pixels, more samples in all
  }
}

TEST_F(Overwrite, APictureOfMoreSamplesIsKept) {
  for (const std::string name : {"a.exr", "a.png"}) {
    expect_ok({"--spp", "4", "-o", name});
    expect_kept(name, {"--spp", "2", "-o", name}, "samples 2:4 of this render");
    expect_kept(name, {"--spp", "3", "--seed", "7", "-q", "-o", name}, "4 samples each, more than the 3");
    expect_kept(name, {"--spp", "4", "--size", "4x4", "-o", name}, "more than the 4 of 4x4");
    EXPECT_TRUE(changes(name, {"--spp", "2", "--force", "-o", name}));
  }
  // Every output is looked at before anything is rendered.
  expect_ok({"--spp", "4", "-o", "b.exr"});
  expect_kept("b.exr", {"--spp", "2", "-o", "new.png", "-o", "b.exr"}, "would be lost");
  EXPECT_FALSE(fs::exists(folder_ / "new.png"));
}

TEST_F(Overwrite, APictureOfAnotherSceneIsKept) {
  for (const std::string name : {"a.exr", "a.png"}) {
    expect_ok({"--spp", "2", "-o", name});
    const std::string before = read_text(folder_ / name);
    const ProcessResult other = render({"--spp", "8", "-o", name}, "bubble");
    EXPECT_EQ(other.code, 6) << other.err;
    EXPECT_THAT(other.err, HasSubstr("of another scene ('cbox-sphere')"));
    EXPECT_TRUE(read_text(folder_ / name) == before);
    // The same scene, edited: rendered again and again.
    const ProcessResult edited = render({"--spp", "2", "-D", "integrator.maxDepth=3", "-o", name});
    EXPECT_EQ(edited.code, 0) << edited.err;
    EXPECT_THAT(edited.err, HasSubstr("by 'path"));
    EXPECT_EQ(render({"--spp", "1", "--force", "-o", name}, "bubble").code, 0);
  }
}

TEST_F(Overwrite, AFilmOfAnotherRenderIsKept) {
  expect_ok({"--spp", "4", "--film", "-o", "f.exr"});
  expect_kept("f.exr", {"--spp", "4", "--film", "--seed", "5", "-o", "f.exr"}, "of seed 0: a film of another render");
  expect_kept("f.exr", {"--spp", "99", "--film", "--size", "16x12", "-o", "f.exr"}, "a film of another render");
  const std::string before = read_text(folder_ / "f.exr");
  EXPECT_EQ(render({"--spp", "9", "--film", "-o", "f.exr"}, "bubble").code, 6);
  EXPECT_TRUE(read_text(folder_ / "f.exr") == before);
  EXPECT_TRUE(changes("f.exr", {"--spp", "4", "--film", "--seed", "5", "--force", "-o", "f.exr"}));
}

// What counts in the end are the samples that there are, not those that were asked for.
TEST_F(Overwrite, ARunThatEndsEarlyWritesBesideWhatIsWorthMore) {
  // More than the longest dispatch of a run without time can add.
  expect_ok({"--size", "64x48", "--spp", "1024", "--seed", "3", "-o", "a.exr", "-o", "a.png"});
  const std::string picture = read_text(folder_ / "a.exr"), display = read_text(folder_ / "a.png");
  const std::vector<std::string> early = {"--size", "64x48", "--spp", "100000000", "--time",
                                          "0.01s",  "-o",    "a.exr", "-o",        "a.png"};
  const ProcessResult stopped = render(early);
  EXPECT_EQ(stopped.code, 0) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("it is kept, and the result of this run goes to a.partial.exr"));
  EXPECT_THAT(stopped.err, HasSubstr("wrote a.partial.exr and a.partial.png"));
  EXPECT_TRUE(read_text(folder_ / "a.exr") == picture);
  EXPECT_TRUE(read_text(folder_ / "a.png") == display);
  EXPECT_TRUE(fs::exists(folder_ / "a.partial.exr"));
  // The same rule holds for what stands beside it.
  expect_ok({"--size", "64x48", "--spp", "1024", "--seed", "3", "--force", "-o", "a.partial.exr"});
  const std::string beside = read_text(folder_ / "a.partial.exr");
  EXPECT_EQ(render(early).code, 0);
  EXPECT_TRUE(read_text(folder_ / "a.partial.exr") == beside);
  EXPECT_TRUE(fs::exists(folder_ / "a.partial-2.exr"));
  std::vector<std::string> forced = early;
  forced.push_back("--force");
  EXPECT_EQ(render(forced).code, 0);
  EXPECT_FALSE(read_text(folder_ / "a.exr") == picture);
}

TEST_F(Overwrite, NamesThatFollowFromTheSceneAreGuardedToo) {
  expect_ok({"--spp", "4"});
  expect_kept("cbox-sphere.exr", {"--spp", "2"}, "would be lost");
}

TEST_F(Overwrite, WhatEtendueDidNotMakeIsKept) {
  write_text(folder_ / "notes.exr", "hello");
  expect_kept("notes.exr", {"--spp", "4", "-o", "notes.exr"}, "not a readable picture");
  expect_ok({"--spp", "1", "-o", "whole.exr"});
  const std::string whole = read_text(folder_ / "whole.exr");
  std::string foreign = whole;
  foreign.replace(foreign.find("Etendue"), 7, "Another");
  write_text(folder_ / "foreign.exr", foreign);
  expect_kept("foreign.exr", {"--spp", "4", "-o", "foreign.exr"}, "a picture that Etendue did not make");
  write_text(folder_ / "torn.exr", whole.substr(0, 100));
  expect_kept("torn.exr", {"--spp", "4", "-o", "torn.exr"}, "not a readable picture");
  EXPECT_TRUE(changes("notes.exr", {"--spp", "1", "--force", "-o", "notes.exr"}));
  // mktemp leaves an empty file behind, which is no loss.
  write_text(folder_ / "empty.exr", "");
  EXPECT_TRUE(changes("empty.exr", {"--spp", "1", "-o", "empty.exr"}));
}

TEST_F(Overwrite, AFilmIsKeptUnlessAFilmOfItsSamplesComes) {
  expect_ok({"--samples", "0:4", "-o", "f.exr"});
  expect_kept("f.exr", {"--samples", "4:8", "-o", "f.exr"}, "samples 0:4 of this render, which would be lost");
  expect_kept("f.exr", {"--spp", "8", "-o", "f.exr"}, "is a film");
  expect_kept("f.exr", {"--spp", "1", "--heat-map", "f.exr", "-o", "x.exr", "--device", "auto"}, "lost");
  EXPECT_FALSE(changes("f.exr", {"--samples", "0:4", "-o", "f.exr"}));  // the same bytes again
  EXPECT_TRUE(changes("f.exr", {"--spp", "8", "--resume", "f.exr", "--film", "-o", "f.exr"}));
}

TEST_F(Overwrite, MergeFollowsTheSameRule) {
  expect_ok({"--samples", "0:4", "-o", "a.exr"});
  expect_ok({"--samples", "4:8", "-o", "b.exr"});
  expect_ok({"--samples", "8:12", "-o", "c.exr"});
  const auto merge = [&](std::vector<std::string> more) {
    more.insert(more.begin(), "merge");
    return etendue(more, folder_);
  };
  EXPECT_EQ(merge({"b.exr", "c.exr", "-o", "a.exr"}).code, 6);
  EXPECT_EQ(merge({"a.exr", "b.exr", "--picture", "-o", "c.exr"}).code, 6);
  EXPECT_EQ(merge({"a.exr", "b.exr", "-o", "c.exr", "-o", "new.png"}).code, 6);
  EXPECT_FALSE(fs::exists(folder_ / "new.png"));
  EXPECT_EQ(merge({"a.exr", "b.exr", "-o", "a.exr"}).code, 0);
  EXPECT_EQ(merge({"b.exr", "c.exr", "--force", "-o", "a.exr"}).code, 0);
}

TEST_F(Overwrite, ReportsReplaceReportsOnly) {
  expect_ok({"--spp", "16", "-o", "a.exr"});
  expect_ok({"--spp", "16", "--seed", "1", "-o", "b.exr", "-o", "b.png"});
  fs::copy_file(SCENES_DIR "/chi2-bsdfs.xml", folder_ / "scene.xml");
  const auto run = [&](std::vector<std::string> arguments) { return etendue(arguments, folder_); };
  for (const std::string option : {"--json", "--junit", "--html"}) {
    for (const std::string file : {"b.exr", "b.png", "scene.xml"}) {
      SCOPED_TRACE(option + " " + file);
      const std::string before = read_text(folder_ / file);
      const ProcessResult result = run({"compare", "a.exr", "b.exr", "--no-flip", option + "=" + file});
      EXPECT_EQ(result.code, 6) << result.err;
      EXPECT_THAT(result.err, HasSubstr("is not a report"));
      EXPECT_TRUE(read_text(folder_ / file) == before);
    }
    for (int again = 0; again < 2; ++again)
      EXPECT_EQ(run({"compare", "a.exr", "b.exr", "--no-flip", "--allow-untested", option + "=r"}).code, 0) << option;
    fs::remove(folder_ / "r");
  }
  EXPECT_EQ(run({"chi2", "scene.xml", "--device", "reference", "--samples", "100", "--junit", "scene.xml"}).code, 6);
  write_text(folder_ / "empty", "");
  EXPECT_EQ(run({"compare", "a.exr", "b.exr", "--no-flip", "--allow-untested", "--json=empty"}).code, 0);
}

TEST_F(Overwrite, NoClobberReplacesNothing) {
  expect_ok({"--spp", "1", "-o", "a.exr"});
  expect_kept("a.exr", {"--spp", "4", "--no-clobber", "-o", "a.exr"}, "--no-clobber keeps it");
  write_text(folder_ / "empty.exr", "");
  expect_kept("empty.exr", {"--spp", "4", "--no-clobber", "-o", "empty.exr"}, "--no-clobber keeps it");
  EXPECT_EQ(render({"--spp", "1", "--force", "--no-clobber", "-o", "a.exr"}).code, 2);
  expect_ok({"--spp", "1", "--no-clobber", "-o", "new.exr"});
}

}  // namespace
}  // namespace etendue::faults
