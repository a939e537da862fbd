#pragma once
/// How much work a dispatch gets.

#include <array>
#include <cstdint>

namespace etendue {

struct PassLimits {
  static constexpr std::uint32_t kLeastPathsPerLane = 4;
  double seconds = 0.25;                              ///< that a dispatch should take
  std::uint64_t most_groups = 1;                      ///< of 64 samples that a dispatch can leave for the film
  std::uint32_t lane_groups = 1;                      ///< workgroups that keep the device busy
  std::uint32_t paths_per_lane = kLeastPathsPerLane;  ///< one after the other, at most
  std::uint32_t fixed_samples = 0, fixed_groups = 0;  ///< 0: chosen here
};

/// Sizes dispatches by the rates measured so far. It decides when samples are computed, never their values.
///
/// Watchdogs and desktop users suffer from the longest dispatch, not from the mean one. So the slowest of the recent
/// dispatches counts, because parts of a picture differ in cost, and none gets more than kMostGrowth times the work of
/// the one before.
class PassSizer {
 public:
  static constexpr double kMostGrowth = 4.0;
  static constexpr std::size_t kRecent = 8;

  explicit PassSizer(const PassLimits& limits) : limits_(limits) {}

  void measured(double paths, double seconds);
  /// Lanes came to the end of their budget: fewer paths in a row.
  void shorten();

  /// Samples of each slot in a pass over the film, where a sample is so many paths. A pass must end soon enough for
  /// signals and time limits.
  std::uint32_t samples(std::uint64_t slots, std::uint32_t paths) const;
  /// Groups of slots that are given so many paths each by one dispatch, or by several where that is too much for one.
  std::uint32_t groups(std::uint32_t left, std::uint32_t paths) const;
  /// Paths of each slot in a dispatch for so many groups.
  std::uint32_t paths(std::uint32_t left, std::uint32_t groups) const;
  /// Workgroups that do it: as many as there are to be, and none has more to do than another.
  std::uint32_t lane_groups(std::uint32_t groups) const;

 private:
  double size() const;

  PassLimits limits_;
  double rate_ = 2e5;  // paths per second; a careful first guess
  std::array<double, kRecent> recent_{};
  std::size_t measurements_ = 0;
};

}  // namespace etendue
