/// parallel_for covers each index once, whatever the grain and the number of threads, and hands on what a body throws.

#include <atomic>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/version.h"

namespace etendue {
namespace {

class CoreParallel : public ::testing::Test {
 protected:
  void TearDown() override { set_thread_count(0); }
};

TEST_F(CoreParallel, CoversEveryIndexOnce) {
  for (const unsigned threads : {1u, 2u, 7u, 64u}) {
    set_thread_count(threads);
    for (const std::uint64_t count : {0ull, 1ull, 2ull, 63ull, 1000ull, 100001ull}) {
      for (const std::uint64_t grain : {0ull, 1ull, 7ull, 1000ull, ~0ull >> 1}) {
        if (count > 2000 && grain <= 1) continue;
        std::vector<std::atomic<int>> seen(count);
        parallel_for(count, grain, [&](std::uint64_t begin, std::uint64_t end) {
          ASSERT_LT(begin, end);
          ASSERT_LE(end, count);
          ASSERT_LE(end - begin, std::max<std::uint64_t>(1, grain));
          for (std::uint64_t i = begin; i < end; ++i) ++seen[i];
        });
        for (const auto& n : seen) ASSERT_EQ(n.load(), 1) << count << " by " << grain << " on " << threads;
      }
    }
  }
}

TEST_F(CoreParallel, RethrowsAndStopsHandingOutWork) {
  for (const unsigned threads : {1u, 4u}) {
    set_thread_count(threads);
    std::atomic<int> started{0};
    const auto run = [&] {
      parallel_for(100000, 1, [&](std::uint64_t begin, std::uint64_t) {
        ++started;
        if (begin == 10) throw Error(ErrorKind::scene, "index 10");
      });
    };
    try {
      run();
      FAIL() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "index 10");
      EXPECT_EQ(error.kind(), ErrorKind::scene);
    }
    EXPECT_LT(started.load(), 100000);
  }
}

TEST_F(CoreParallel, SeveralThreadsReallyWork) {
  set_thread_count(2);
  // Two chunks that wait for each other: with one thread this would never end.
  std::atomic<int> arrived{0};
  parallel_for(2, 1, [&](std::uint64_t, std::uint64_t) {
    ++arrived;
    for (int i = 0; i < 20000 && arrived < 2; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  EXPECT_EQ(arrived.load(), 2);
}

TEST_F(CoreParallel, NestedLoopsFinish) {
  set_thread_count(3);
  std::atomic<std::uint64_t> sum{0};
  parallel_for(10, 1, [&](std::uint64_t begin, std::uint64_t) {
    parallel_for(100, 9, [&](std::uint64_t b, std::uint64_t e) {
      for (std::uint64_t i = b; i < e; ++i) sum += begin * 100 + i;
    });
  });
  EXPECT_EQ(sum.load(), 999ull * 1000 / 2);
}

TEST_F(CoreParallel, ThreadCountCanBeSetAndReset) {
  set_thread_count(5);
  EXPECT_EQ(thread_count(), 5u);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1u);
}

TEST(CoreVersion, HasThreeNumbers) {
  int major = -1, minor = -1, patch = -1;
  EXPECT_EQ(std::sscanf(version(), "%d.%d.%d", &major, &minor, &patch), 3);
}

}  // namespace
}  // namespace etendue
