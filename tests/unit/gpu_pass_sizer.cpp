/// Dispatches sized for made-up devices: how long the longest is.

#include "gpu/pass_sizer.h"

#include <algorithm>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "gpu_types.h"

namespace etendue {
namespace {

constexpr double kTarget = 0.25;

// Times of dispatches over a film that never ends, on a device that computes `rate(i)` paths a second in dispatch i.
std::vector<double> times(std::size_t count, const std::function<double(std::size_t)>& rate) {
  PassSizer sizer({.seconds = kTarget, .most_groups = 1u << 20, .lane_groups = 32, .paths_per_lane = 256});
  std::vector<double> out;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t groups = sizer.groups(1u << 16, 1);
    const double paths = static_cast<double>(groups) * sizer.paths(1, groups) * gpu::kWorkgroupSize;
    out.push_back(paths / rate(i));
    sizer.measured(paths, out.back());
  }
  return out;
}

double longest(const std::vector<double>& times, std::size_t from) {
  return *std::max_element(times.begin() + static_cast<std::ptrdiff_t>(from), times.end());
}

TEST(PassSizer, ComesToTheTargetAndStaysThere) {
  const auto t = times(20, [](std::size_t) { return 2e6; });
  EXPECT_LE(longest(t, 0), 1.1 * kTarget);
  EXPECT_GE(t[4], 0.8 * kTarget);
}

TEST(PassSizer, NeverGrowsByMoreThanItsBound) {
  const auto t = times(12, [](std::size_t i) { return i == 0 ? 2e4 : 2e6; });  // the driver compiles in the first
  for (std::size_t i = 2; i < t.size(); ++i) EXPECT_LE(t[i], 1.1 * PassSizer::kMostGrowth * t[i - 1]) << i;
  EXPECT_GE(t[8], 0.8 * kTarget) << "what the compilation took is forgotten";
}

TEST(PassSizer, TheDearestPartOfThePictureCounts) {
  // Of six dispatches over a picture one meets glass, at a twentieth of the rate.
  const auto t = times(60, [](std::size_t i) { return i % 6 == 3 ? 1e5 : 2e6; });
  EXPECT_LE(longest(t, 6), 1.1 * kTarget);
}

TEST(PassSizer, ASlowedDeviceHasOneLongDispatch) {
  const auto t = times(60, [](std::size_t i) { return i < 20 ? 2e6 : i < 40 ? 1e5 : 2e6; });
  EXPECT_GT(t[20], 2.0 * kTarget);
  EXPECT_LE(longest(t, 21), 1.1 * kTarget);
  EXPECT_GE(t[55], 0.8 * kTarget) << "and it recovers";
}

TEST(PassSizer, WorkIsSharedEvenly) {
  const PassSizer sizer({.seconds = kTarget, .most_groups = 1000, .lane_groups = 32, .paths_per_lane = 4});
  EXPECT_EQ(sizer.groups(1001, 1000), 32u);  // never fewer than keep the device busy
  EXPECT_EQ(sizer.groups(40, 1000), 20u);
  EXPECT_EQ(sizer.lane_groups(33), 17u);
}

}  // namespace
}  // namespace etendue
