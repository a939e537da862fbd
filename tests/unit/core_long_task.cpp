/// What a person sees of a long computation.

#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/long_task.h"
#include "core/terminal.h"

namespace etendue {
namespace {

/// Keeps what it is told.
class Recorder : public log::Sink {
 public:
  Recorder() { log::set_sink(this); }
  ~Recorder() override { log::set_sink(nullptr); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  void message(log::Level, std::string_view sentence) noexcept override { lines.emplace_back(sentence); }
  void progress(std::string_view what, double fraction) noexcept override {
    lines.push_back(std::string(what) + " " + std::to_string(fraction));
  }
  void progress_ended(std::string_view what) noexcept override { lines.push_back(std::string(what) + " ended"); }

  std::vector<std::string> lines;
};

void run_task(double silent_seconds) {
  LongTask task("Building the tree", 8, LongTask::Seconds(silent_seconds));
  for (int i = 0; i < 2; ++i) task.advance(1);  // the second part follows too soon to be told
}

TEST(LongTask, ShortTasksStaySilent) {
  const Recorder recorder;
  run_task(60.0);
  EXPECT_TRUE(recorder.lines.empty());
}

TEST(LongTask, TellsTheSinkHowFarItIs) {
  const Recorder recorder;
  run_task(0.0);
  EXPECT_EQ(recorder.lines, (std::vector<std::string>{"Building the tree 0.125000", "Building the tree ended"}));
}

TEST(LongTask, RespectsTheLogLevel) {
  const Recorder recorder;
  const log::Level before = log::level();
  log::set_level(log::Level::error);
  run_task(0.0);
  log::warning("dropped");
  log::error("told");
  log::set_level(before);
  EXPECT_EQ(recorder.lines, std::vector<std::string>{"told"});
}

TEST(LongTask, CountsPartsOfAllThreads) {
  const Recorder recorder;
  {
    constexpr int kThreads = 4;
    LongTask task("Counting", 400, LongTask::Seconds(1.0));  // more than the threads take under a sanitizer
    std::vector<std::jthread> threads;
    threads.reserve(kThreads);
    for (int t = 0; t < kThreads; ++t)
      threads.emplace_back([&] {
        for (int i = 0; i < 99; ++i) task.advance(1);
      });
    threads.clear();
    std::this_thread::sleep_for(std::chrono::milliseconds(1010));
    task.advance(4);
  }
  EXPECT_EQ(recorder.lines, (std::vector<std::string>{"Counting 1.000000", "Counting ended"}));
}

TEST(Log, ALibraryAloneWritesNothing) {
  testing::internal::CaptureStderr();
  run_task(0.0);
  log::error("Nobody asked for this.");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(TerminalLog, WithoutATerminalOneLineEveryFewSeconds) {
  testing::internal::CaptureStderr();
  {
    TerminalLog terminal;
    for (const double fraction : {0.125, 0.25, 0.5}) terminal.progress("Building the tree", fraction);
    terminal.progress_ended("Building the tree");
    log::warning("Odd.");
    log::info("Plain.");
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "Building the tree: 12 %\nwarning: Odd.\nnote: Plain.\n");
}

}  // namespace
}  // namespace etendue
