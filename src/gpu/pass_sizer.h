#pragma once
/// Chooses how much work a dispatch gets.

#include <array>
#include <cstdint>

namespace etendue {

struct PassLimits {
  static constexpr std::uint32_t kLeastPathsPerLane = 4;
  double seconds = 0.25;                              ///< target duration of a dispatch
  std::uint64_t most_groups = 1;                      ///< of 64 samples, as many as a dispatch can leave for the film
  std::uint32_t lane_groups = 1;                      ///< workgroups that keep the device busy
  std::uint32_t paths_per_lane = kLeastPathsPerLane;  ///< most paths of a lane, one after the other
  std::uint32_t fixed_samples = 0, fixed_groups = 0;  ///< 0: chosen here
};

/// Sizes dispatches by the rates measured so far. It decides when samples are computed, never their values.
///
/// Watchdogs and desktop users suffer from the longest dispatch, not from the average one. The slowest of the recent
/// dispatches therefore counts, because parts of a picture differ in cost, and none gets more than kMostGrowth times
/// the work of the one before.
class PassSizer {
 public:
  static constexpr double kMostGrowth = 4.0;
  static constexpr std::size_t kRecent = 8;

  explicit PassSizer(const PassLimits& limits) : limits_(limits) {}

  void measured(double paths, double seconds);
  /// Reports that lanes have exhausted their budget: they get fewer paths in a row from now on.
  void shorten();

  /// Samples of each slot in a pass over the film, with so many paths per sample. A pass must end soon enough to react
  /// to signals and time limits.
  std::uint32_t samples(std::uint64_t slots, std::uint32_t paths) const;
  /// Number of groups of slots that one dispatch serves with so many paths per slot; if these are too many for one
  /// dispatch, several share them.
  std::uint32_t groups(std::uint32_t left, std::uint32_t paths) const;
  /// Paths of each slot in a dispatch for so many groups.
  std::uint32_t paths(std::uint32_t left, std::uint32_t groups) const;
  /// Number of workgroups, chosen so that all have the same amount of work.
  std::uint32_t lane_groups(std::uint32_t groups) const;

 private:
  double size() const;

  PassLimits limits_;
  double rate_ = 2e5;  // paths per second; the first guess is cautious
  std::array<double, kRecent> recent_{};
  std::size_t measurements_ = 0;
};

}  // namespace etendue
