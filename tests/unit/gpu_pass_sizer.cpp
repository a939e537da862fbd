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
  constexpr std::uint32_t kFilm = 1u << 16;
  FilmPlace place;
  for (std::size_t i = 0; i < count; ++i) {
    place.first = place.first + place.count < kFilm ? place.first + place.count : 0;
    place.count = sizer.groups({place.first, kFilm - place.first}, 1);
    const std::uint32_t paths = sizer.paths(1, place);
    out.push_back(static_cast<double>(place.count) * paths * gpu::kWorkgroupSize / rate(i));
    sizer.measured(place, paths, out.back());
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

// As many paths as keep it busy would take ten times as long as they may.
TEST(PassSizer, AWatchedDeviceNeverHasALongDispatch) {
  PassSizer sizer({.seconds = kTarget,
                   .most_groups = 1u << 20,
                   .lane_groups = 2048,
                   .paths_per_lane = 256,
                   .caution = 4.0,
                   .first_rate = 1e4});
  constexpr double kRate = 5e4;
  constexpr std::uint32_t kFilm = 1u << 16, kPaths = 16;
  double longest = 0.0;
  for (FilmPlace place; place.first < kFilm; place.first += place.count) {
    place.count = sizer.groups({place.first, kFilm - place.first}, kPaths);
    for (std::uint32_t done = 0, paths = 0; done < kPaths; done += paths) {
      paths = sizer.paths(kPaths - done, place);
      const double seconds = static_cast<double>(place.count) * paths * gpu::kWorkgroupSize / kRate;
      longest = std::max(longest, seconds);
      sizer.measured(place, paths, seconds);
    }
  }
  EXPECT_LE(longest, 1.1 * kTarget);
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

// Passes over a film of 64 000 groups of which 1 000 cost twenty times as much; the longest dispatch of each pass.
std::vector<double> longest_of_passes(int passes, double caution) {
  PassSizer sizer(
      {.seconds = kTarget, .most_groups = 1u << 20, .lane_groups = 32, .paths_per_lane = 256, .caution = caution});
  std::vector<double> out;
  for (int pass = 0; pass < passes; ++pass) {
    out.push_back(0.0);
    for (FilmPlace place; place.first < 64000; place.first += place.count) {
      place.count = sizer.groups({place.first, 64000 - place.first}, 1);
      double cost = 0.0;
      for (std::uint32_t g = place.first; g < place.first + place.count; ++g)
        cost += (g >= 50000 && g < 51000 ? 20.0 : 1.0) * gpu::kWorkgroupSize / 5e5;
      out.back() = std::max(out.back(), cost);
      sizer.measured(place, 1, cost);
    }
  }
  return out;
}

// Between two visits of the dear place are more dispatches than count as recent.
TEST(PassSizer, PlacesAreRememberedFromPassToPass) {
  const auto longest = longest_of_passes(12, 1.0);
  EXPECT_GT(longest[0], 4.0 * kTarget);
  for (std::size_t pass = 2; pass < longest.size(); ++pass) EXPECT_LE(longest[pass], 1.5 * kTarget) << pass;
}

TEST(PassSizer, UnknownPlacesAreTakenToBeDearer) {
  EXPECT_LE(longest_of_passes(1, 4.0).front(), 0.5 * longest_of_passes(1, 1.0).front());
}

TEST(PassSizer, WhatWasRememberedOfAnotherFilmIsForgotten) {
  PassSizer sizer({.seconds = kTarget, .most_groups = 1u << 20, .lane_groups = 32, .paths_per_lane = 256});
  const FilmPlace film{0, 1u << 16};
  const auto fast = [&](std::uint32_t first) { sizer.measured({first, 64}, 1, 64.0 * gpu::kWorkgroupSize / 2e6); };
  fast(0);
  sizer.measured({0, 64}, 1, 1.0);
  for (std::uint32_t i = 1; i < 30; ++i) fast(64 * i);
  EXPECT_LT(sizer.groups(film, 1), 100u);
  sizer.forget_places();
  EXPECT_GT(sizer.groups(film, 1), 1000u);
}

TEST(PassSizer, WorkIsSharedEvenly) {
  const PassSizer sizer({.seconds = kTarget, .most_groups = 1000, .lane_groups = 32, .paths_per_lane = 4});
  EXPECT_EQ(sizer.groups({0, 1001}, 1000), 32u);  // never fewer than keep the device busy
  EXPECT_EQ(sizer.groups({0, 40}, 1000), 20u);
  EXPECT_EQ(sizer.lane_groups(33), 17u);
}

}  // namespace
}  // namespace etendue
