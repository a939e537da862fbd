#pragma once
/// Chooses how much work a dispatch gets.

#include <array>
#include <cstdint>
#include <vector>

namespace etendue {

struct PassLimits {
  static constexpr std::uint32_t kLeastPathsPerLane = 4;
  double seconds = 0.25;                              ///< target duration of a dispatch
  std::uint64_t most_groups = 1;                      ///< of 64 samples, as many as a dispatch can leave for the film
  std::uint32_t lane_groups = 1;                      ///< workgroups that keep the device busy
  std::uint32_t paths_per_lane = kLeastPathsPerLane;  ///< most paths of a lane, one after the other
  std::uint32_t fixed_samples = 0, fixed_groups = 0;  ///< 0: chosen here
  /// How many times dearer than the recent ones a place of the film may be that is still unknown.
  double caution = 1.0;
  double first_rate = 2e5;  ///< paths per second, assumed for the first dispatch
};

/// Groups of film slots, counted over the whole film.
struct FilmPlace {
  std::uint32_t first = 0, count = 0;
};

/// Sizes dispatches by the rates measured so far. It decides when samples are computed, never their values.
///
/// Watchdogs and desktop users suffer from the longest dispatch, not from the average one. The slowest of the recent
/// dispatches therefore counts, and the speed that is assumed grows by kMostGrowth at most from one to the next. Parts
/// of a picture differ in cost, and a pass may take more dispatches than are recent; so what each place of the film
/// cost when it was last rendered counts as well, and places that are still unknown are taken to be dearer.
class PassSizer {
 public:
  static constexpr double kMostGrowth = 4.0;
  static constexpr std::size_t kRecent = 8;

  explicit PassSizer(const PassLimits& limits) : limits_(limits), rate_(limits.first_rate) {}

  /// A dispatch gave each slot of a place so many paths.
  void measured(FilmPlace place, double paths, double seconds);
  /// The next film is another one.
  void forget_places() { costs_.clear(); }
  /// Reports that lanes have exhausted their budget: they get fewer paths in a row from now on.
  void shorten();

  /// Samples of each slot in a pass over the film, with so many paths per sample. A pass must end soon enough to react
  /// to signals and time limits.
  std::uint32_t samples(std::uint64_t slots, std::uint32_t paths) const;
  /// Number of the groups left that one dispatch serves with so many paths per slot, the first ones; if these are too
  /// many for one dispatch, several share them.
  std::uint32_t groups(FilmPlace left, std::uint32_t paths) const;
  /// Paths of each slot in a dispatch for a place.
  std::uint32_t paths(std::uint32_t left, FilmPlace place) const;
  /// Number of workgroups, chosen so that all have the same amount of work.
  std::uint32_t lane_groups(std::uint32_t groups) const;

 private:
  double most() const;
  double cost_at(std::size_t index) const;
  double seconds(FilmPlace place) const;
  std::uint32_t affordable(FilmPlace left, double seconds) const;

  PassLimits limits_;
  std::vector<double> costs_;  // seconds of a path, for every lane_groups groups; 0: unknown
  double rate_;                // paths per second
  std::array<double, kRecent> recent_{};
  std::size_t measurements_ = 0;
};

}  // namespace etendue
