/// What a person sees of a long computation.

#include <thread>

#include <gtest/gtest.h>

#include "core/log.h"
#include "core/long_task.h"

namespace etendue {
namespace {

std::string said(double silent_seconds) {
  testing::internal::CaptureStderr();
  {
    LongTask task("Building the tree", 8, LongTask::Seconds(silent_seconds));
    for (int i = 0; i < 2; ++i) task.advance(1);
  }
  return testing::internal::GetCapturedStderr();
}

TEST(LongTask, ShortTasksStaySilent) {
  EXPECT_EQ(said(60.0), "");
}

TEST(LongTask, SaysHowFarItIsWithoutATerminalOneLineEveryFewSeconds) {
  EXPECT_EQ(said(0.0), "Building the tree: 12 %\n");  // the second part follows too soon
}

TEST(LongTask, RespectsTheLogLevel) {
  const log::Level before = log::level();
  log::set_level(log::Level::error);
  EXPECT_EQ(said(0.0), "");
  log::set_level(before);
}

TEST(LongTask, CountsPartsOfAllThreads) {
  testing::internal::CaptureStderr();
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
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "Counting: 100 %\n");
}

}  // namespace
}  // namespace etendue
