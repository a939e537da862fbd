/// Terminals that go away, streams that are closed, full or without a reader, and signals that come twice: the render
/// goes on or stops as it should, and its files are whole.

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>

#include "render_fixture.h"

namespace etendue::faults {
namespace {

using testing::HasSubstr;

class LostStreams : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (!IsSkipped()) expect_ok(render({"--spp", "40", "--film", "-o", "one.exr"}));
  }
  void TearDown() override {
    for (const int descriptor : descriptors_) close(descriptor);
    RenderTest::TearDown();
  }
  int keep(int descriptor) {
    EXPECT_GE(descriptor, 0);
    descriptors_.push_back(descriptor);
    return descriptor;
  }
  /// The end of a new pipe that is written to. Nobody reads; the other end is open until the test is over, or closed.
  int pipe_end(bool open) {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    if (open) {
      keep(ends[0]);
    } else {
      close(ends[0]);
    }
    return keep(ends[1]);
  }
  /// A terminal: the side of its screen, and the side of programs.
  std::array<int, 2> open_terminal() {
    const int screen = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    EXPECT_TRUE(screen >= 0 && grantpt(screen) == 0 && unlockpt(screen) == 0);
    return {screen, keep(open(ptsname(screen), O_RDWR | O_NOCTTY | O_CLOEXEC))};
  }
  /// Renders with these streams and expects the film of an undisturbed run.
  void expect_film(const ProcessOptions& options) const {
    const ProcessResult result = run(render({"--spp", "40", "--film", "-o", "x.exr"}), options);
    EXPECT_EQ(result.code, 0) << result.err;
    expect_same("one.exr", "x.exr");
  }
  std::vector<int> descriptors_;
};

TEST_F(LostStreams, MessagesThatNobodyTakesCostNothing) {
  expect_film({.err = keep(open(full_device().c_str(), O_WRONLY | O_CLOEXEC))});
  expect_film({.close_err = true});
  expect_film({.err = pipe_end(false)});
  expect_film({.out = pipe_end(false), .err = pipe_end(false), .close_out = true, .close_err = true});
}

TEST_F(LostStreams, AFullPipeHoldsNobody) {
  const int end = pipe_end(true);
  fcntl(end, F_SETFL, O_NONBLOCK);
  const std::string page(4096, 'x');
  while (write(end, page.data(), page.size()) > 0) {
  }
  fcntl(end, F_SETFL, 0);
  Process process(render({"--spp", "40", "--film", "-o", "x.exr"}), folder_, {.err = end});
  EXPECT_EQ(process.wait(60.0).code, 0);
  expect_same("one.exr", "x.exr");
}

TEST_F(LostStreams, AFileSizeLimitUnderTheMessages) {
  const int log = keep(open((folder_ / "log").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600));
  // A hole, larger than the limit, which leaves room for a driver that keeps its memory in files.
  constexpr std::int64_t kGiB = std::int64_t{1} << 30;
  ASSERT_EQ(ftruncate(log, 4 * kGiB), 0);
  expect_film({.file_size_limit = 2 * kGiB, .err = log});
}

// The results of the command go to stdout: files are written all the same, and the code tells.
TEST_F(LostStreams, ResultsThatNobodyTakesAreAnErrorAfterTheFilesAreWritten) {
  const std::vector<ProcessOptions> all = {
      {.out = keep(open(full_device().c_str(), O_WRONLY | O_CLOEXEC))}, {.close_out = true}, {.out = pipe_end(false)}};
  for (const ProcessOptions& options : all) {
    const ProcessResult result = run(render({"--spp", "40", "--film", "-o", "x.exr", "--json"}), options);
    expect_error(result, 6, "cannot be written to stdout");
    expect_same("one.exr", "x.exr");
    std::filesystem::remove(folder_ / "x.exr");
  }
}

TEST_F(LostStreams, WhatIsAskedOfTheProgramItselfIsAResultToo) {
  const int full = keep(open(full_device().c_str(), O_WRONLY | O_CLOEXEC));
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--version"}, {"--help"}, {"render", "--help"}, {"devices", "--help"}}) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    expect_error(run(arguments, {.close_out = true}), 6, "cannot be written to stdout: Bad file descriptor");
    expect_error(run(arguments, {.out = full}), 6, "cannot be written to stdout: No space left on device");
  }
}

// Whatever ends a program by default and can be caught: limits, timers, signals of the user's own.
TEST_F(LostStreams, SignalsOfLimitsAndTimersSaveWhatIsDone) {
  for (const int signal : {SIGXCPU, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF, SIGPWR, SIGPOLL}) {
    SCOPED_TRACE(signal);
    Process process(render({"--spp", "10000000", "--checkpoint", "ck.exr", "--checkpoint-every", "200ms",
                            "--pass-samples", "4", "-o", "x.exr"}),
                    folder_);
    ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
    process.signal(signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    process.signal(signal);  // never the impatient one
    const ProcessResult result = process.wait();
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_THAT(result.err, testing::Not(HasSubstr("Aborted")));
    EXPECT_TRUE(exists("x.exr"));
    std::filesystem::remove(folder_ / "ck.exr");
    std::filesystem::remove(folder_ / "x.exr");
  }
}

TEST_F(LostStreams, ResultFilesDoNotNeedStdout) {
  const ProcessResult result = run({"compare", "one.exr", "one.exr", "--json=r.json", "--junit", "gone/r.xml"});
  expect_error(result, 6, "gone/r.xml");  // told before any work
  EXPECT_FALSE(exists("r.json"));
  const ProcessResult full = run({"compare", "one.exr", "one.exr", "--no-flip", "--json=r.json"},
                                 {.out = keep(open(full_device().c_str(), O_WRONLY | O_CLOEXEC))});
  expect_error(full, 6, "cannot be written to stdout: No space left on device");
  EXPECT_TRUE(exists("r.json"));
  expect_error(run({"compare", "one.exr", "one.exr", "--json=r.json", "--html", "./r.json"}), 2, "are the same file");
}

TEST_F(LostStreams, ATerminalThatGoesAwaySavesWhatIsDone) {
  const auto [screen, terminal] = open_terminal();
  Process process(render({"--spp", "10000000", "--checkpoint", "ck.exr", "--checkpoint-every", "200ms",
                          "--pass-samples", "4", "--film", "-o", "x.exr"}),
                  folder_, {.out = terminal, .err = terminal, .owns_terminal = true});
  EXPECT_TRUE(wait_until([&] { return exists("ck.exr"); }));
  close(screen);  // SIGHUP, and what is written now fails
  EXPECT_EQ(process.wait(60.0).code, 130);
  expect_same("x.exr", "ck.exr");
  expect_ok(render({"--spp", samples_of("x.exr"), "--film", "-o", "undisturbed.exr"}));
  expect_same("x.exr", "undisturbed.exr");
}

TEST_F(LostStreams, UnderNohupADeadTerminalDisturbsNothing) {
  const auto [screen, terminal] = open_terminal();
  Process process(render({"--spp", "10000000", "--time", "4s", "--checkpoint", "ck.exr", "--checkpoint-every", "200ms",
                          "--pass-samples", "4", "--film", "-o", "x.exr"}),
                  folder_, {.out = terminal, .err = terminal, .owns_terminal = true, .ignores_hangup = true});
  EXPECT_TRUE(wait_until([&] { return exists("ck.exr"); }));
  EXPECT_FALSE(exists("x.exr"));
  close(screen);
  EXPECT_EQ(process.wait(60.0).code, 0);
  expect_same("x.exr", "ck.exr");
}

// `timeout` signals its child and then its group, so the child is signalled twice.
TEST_F(LostStreams, TheTwoSignalsOfTimeoutAreOneRequest) {
  for (const int signal : {SIGTERM, SIGINT}) {
    Process process({"render", kScene, "--size", "400x300", "--spp", "10000000", "--pass-samples", "64", "--checkpoint",
                     "ck.exr", "--checkpoint-every", "1ms", "-o", "x.exr"},
                    folder_);
    ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
    process.signal(signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    process.signal(signal);
    const ProcessResult result = process.wait();
    EXPECT_EQ(result.code, 130);
    EXPECT_THAT(result.err, testing::Not(HasSubstr("Aborted")));
    EXPECT_TRUE(exists("x.exr"));
    std::filesystem::remove(folder_ / "ck.exr");
    std::filesystem::remove(folder_ / "x.exr");
  }
}

// A shell and the kernel both tell of a terminal that is gone, and the session may be ended with SIGTERM afterwards.
TEST_F(LostStreams, AHangupIsNeverTheImpatientSignal) {
  // The device hangs, so that the pass that the first signal lets finish never does.
  Process process(render({"--spp", "1000", "-o", "x.exr"}), folder_,
                  {.environment = {{"VK_LAYER_PATH", FAULT_LAYER_FOLDER},
                                   {"VK_INSTANCE_LAYERS", "VK_LAYER_ETENDUE_fault"},
                                   {"ETENDUE_FAULT", "hang"}}});
  std::this_thread::sleep_for(std::chrono::seconds(2));
  for (const int signal : {SIGHUP, SIGHUP, SIGTERM, SIGHUP}) {
    process.signal(signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    EXPECT_TRUE(process.is_running()) << signal;
  }
  process.signal(SIGTERM);
  const ProcessResult result = process.wait(30.0);
  EXPECT_EQ(result.code, 130);
  EXPECT_THAT(result.err, HasSubstr("Aborted"));
}

}  // namespace
}  // namespace etendue::faults
