/// A device that is slow, becomes slow, or takes long for a part of the picture: how long its dispatches take. The
/// layer's own log is judged, whose times do not depend on how busy this machine is: that only makes dispatches
/// shorter.

#include <algorithm>
#include <fstream>

#include "render_fixture.h"

namespace etendue::faults {
namespace {

constexpr double kTarget = 0.1;  // seconds

struct Dispatch {
  std::uint32_t first = 0, groups = 0, paths = 0;
  double seconds = 0;
  double work() const { return static_cast<double>(groups) * paths; }
};

class SlowDevice : public RenderTest {
 protected:
  // 4 800 groups of 64 pixels. One thread: a dispatch then needs 16 groups to keep the device busy.
  static std::vector<std::string> large(const std::string& spp, const std::string& out) {
    return {"render", kScene, "--size",    "640x480", "--spp",           spp,     "--film",
            "-o",     out,    "--threads", "1",       "--dispatch-time", "100ms", "-q"};
  }
  // Renders on a device that takes so many nanoseconds longer for each path.
  std::vector<Dispatch> slow(const std::string& spp, std::map<std::string, std::string> how, int after = 0,
                             const std::string& times = "1000000") {
    ProcessOptions options = fault("slow", after, times);
    options.environment.merge(how);
    options.environment["ETENDUE_FAULT_LOG"] = folder_ / "log";
    expect_ok(large(spp, "slow.exr"), options);
    expect_ok(large(spp, "fast.exr"));
    expect_same("slow.exr", "fast.exr");
    std::vector<Dispatch> dispatches;
    std::ifstream log(folder_ / "log");
    for (Dispatch d; log >> d.first >> d.groups >> d.paths >> d.seconds; dispatches.push_back(d)) d.seconds *= 1e-9;
    return dispatches;
  }
  // From dispatch number `from` on.
  static double longest(const std::vector<Dispatch>& dispatches, std::size_t from) {
    double longest = 0.0;
    for (std::size_t i = from; i < dispatches.size(); ++i) longest = std::max(longest, dispatches[i].seconds);
    return longest;
  }
  // Number of the dispatch that begins this pass over the film, counted from 0.
  static std::size_t begin_of_pass(const std::vector<Dispatch>& dispatches, int pass) {
    const auto begins = [&](const Dispatch& d) { return d.first == 0 && pass-- == 0; };
    return static_cast<std::size_t>(std::ranges::find_if(dispatches, begins) - dispatches.begin());
  }
};

TEST_F(SlowDevice, DispatchesAreShort) {
  const auto dispatches = slow("1", {{"ETENDUE_FAULT_PATH", "10000"}});
  ASSERT_GT(dispatches.size(), 10u);
  EXPECT_LE(longest(dispatches, 0), 1.1 * kTarget);
}

TEST_F(SlowDevice, ADeviceThatBecomesSlowHasOneLongDispatch) {
  const auto dispatches = slow("3", {{"ETENDUE_FAULT_PATH", "10000"}}, 3);
  ASSERT_GT(dispatches.size(), 16u);
  EXPECT_LE(longest(dispatches, 4), 1.1 * kTarget);
}

TEST_F(SlowDevice, ADeviceThatBecomesFastGetsFourTimesTheWorkAtMost) {
  const auto dispatches = slow("4", {{"ETENDUE_FAULT_PATH", "10000"}}, 0, "12");
  const std::size_t end = begin_of_pass(dispatches, 1);  // later on it is also known what places cost
  ASSERT_GT(end, 20u);
  // A dispatch may begin among 16 groups of which the last one has told what they cost.
  for (std::size_t i = 1; i < end; ++i) EXPECT_LE(dispatches[i].work(), 4.0 * dispatches[i - 1].work() + 20.0) << i;
}

// Glass among walls: 60 groups of the 4 800 take twenty times as long. Each pass has more dispatches than are recent.
TEST_F(SlowDevice, WhatAPlaceOfThePictureCostsIsRemembered) {
  const auto dispatches = slow("5", {{"ETENDUE_FAULT_PATH", "4000"},
                                     {"ETENDUE_FAULT_FROM", "2500"},
                                     {"ETENDUE_FAULT_TO", "2560"},
                                     {"ETENDUE_FAULT_DEAR", "20"}});
  ASSERT_GT(begin_of_pass(dispatches, 1), 16u);
  ASSERT_LT(begin_of_pass(dispatches, 4), dispatches.size());
  // While a place is unknown, it is taken to be four times dearer than those before.
  EXPECT_LE(longest(dispatches, 1), 1.1 * kTarget * 20 / 4);
  // A hiccup of this machine can look like a place that became dear, and mislead for a while.
  EXPECT_LE(longest(dispatches, begin_of_pass(dispatches, 2)), 2.0 * kTarget);
}

}  // namespace
}  // namespace etendue::faults
