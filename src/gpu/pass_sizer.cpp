#include "gpu/pass_sizer.h"

#include <algorithm>
#include <cmath>

#include "gpu_types.h"

namespace etendue {
namespace {

// Calls visit(index, groups) for each stretch of `length` groups that a place touches, until it returns false.
template <typename Visit>
void for_each_stretch(FilmPlace place, std::uint32_t length, Visit visit) {
  const std::uint64_t end = std::uint64_t{place.first} + place.count;
  for (std::uint64_t at = place.first; at < end;) {
    const std::uint64_t index = at / length;
    const std::uint64_t next = std::min(end, (index + 1) * length);
    if (!visit(static_cast<std::size_t>(index), static_cast<double>(next - at))) return;
    at = next;
  }
}

}  // namespace

void PassSizer::measured(FilmPlace place, double paths, double seconds) {
  if (!(seconds > 0.0)) return;
  const double cost = seconds / (paths * place.count * gpu::kWorkgroupSize);
  // The first measurement may include a compilation, or lack the dispatch that did, so it only sizes the next one.
  if (measurements_ > 0) {
    recent_[(measurements_ - 1) % kRecent] = 1.0 / cost;
    // Where the costs of several stretches are known, a dispatch over all of them does not level them. If it took less
    // than expected, one of them was too dear, maybe by a hiccup, but which? They fall slowly, by the square root.
    costs_.resize(std::max<std::size_t>(costs_.size(), (place.first + place.count - 1) / limits_.lane_groups + 1));
    double expected = 0.0;
    for_each_stretch(place, limits_.lane_groups, [&](std::size_t index, double groups) {
      if (costs_[index] == 0.0) costs_[index] = cost;
      expected += groups * costs_[index];
      return true;
    });
    const double ratio = cost * place.count / expected;
    for_each_stretch(place, limits_.lane_groups, [&](std::size_t index, double) {
      costs_[index] *= ratio < 1.0 ? std::sqrt(ratio) : ratio;
      return true;
    });
  }
  const std::size_t known = std::min(measurements_, kRecent);
  ++measurements_;
  const double slowest = known > 0 ? *std::min_element(recent_.begin(), recent_.begin() + known) : 1.0 / cost;
  rate_ = std::min(slowest, kMostGrowth * rate_);
}

void PassSizer::shorten() {
  limits_.paths_per_lane = std::max(limits_.paths_per_lane / 2, PassLimits::kLeastPathsPerLane);
}

std::uint32_t PassSizer::samples(std::uint64_t slots, std::uint32_t paths) const {
  if (limits_.fixed_samples > 0) return limits_.fixed_samples;
  const double affordable = limits_.seconds * rate_ / (static_cast<double>(slots) * paths);
  return static_cast<std::uint32_t>(std::clamp(affordable, 1.0, 64.0));
}

std::uint32_t PassSizer::groups(FilmPlace left, std::uint32_t paths) const {
  const auto most_groups = static_cast<std::uint32_t>(std::min<std::uint64_t>(left.count, limits_.most_groups));
  if (limits_.fixed_groups > 0) return std::min(limits_.fixed_groups, most_groups);
  const auto most_wanted = static_cast<std::uint32_t>(most() / paths);
  const FilmPlace most_left{left.first, most_groups};
  const std::uint32_t wanted = std::min(affordable(most_left, limits_.seconds / paths), most_wanted);
  // Fewer paths in a row leave time for more lanes; as few as keep a device busy are too many if it is slow.
  const std::uint32_t busy = std::clamp(affordable(most_left, limits_.seconds), 1u, limits_.lane_groups);
  const std::uint32_t groups = std::min(std::max(wanted, busy), most_groups);
  const std::uint32_t chunks = (left.count + groups - 1) / groups;
  return (left.count + chunks - 1) / chunks;  // all of equal size, where the film costs the same everywhere
}

std::uint32_t PassSizer::paths(std::uint32_t left, FilmPlace place) const {
  const double affordable = std::min(limits_.seconds / seconds(place), most() / place.count);
  return static_cast<std::uint32_t>(std::clamp(affordable, 1.0, static_cast<double>(left)));
}

std::uint32_t PassSizer::lane_groups(std::uint32_t groups) const {
  const std::uint32_t rounds = (groups + limits_.lane_groups - 1) / limits_.lane_groups;
  return (groups + rounds - 1) / rounds;
}

// Groups of 64 paths in a dispatch.
double PassSizer::most() const {
  const std::uint64_t in_a_row = std::uint64_t{limits_.lane_groups} * limits_.paths_per_lane;
  return static_cast<double>(std::min(limits_.most_groups, in_a_row));
}

// Seconds that a path may take.
double PassSizer::cost_at(std::size_t index) const {
  if (index >= costs_.size() || costs_[index] == 0.0) return limits_.caution / rate_;
  return std::max(costs_[index], 1.0 / rate_);
}

// Of one path for each slot.
double PassSizer::seconds(FilmPlace place) const {
  double sum = 0.0;
  for_each_stretch(place, limits_.lane_groups, [&](std::size_t index, double groups) {
    sum += groups * cost_at(index);
    return true;
  });
  return sum * gpu::kWorkgroupSize;
}

// The first of the groups left for which a path each takes no longer than that.
std::uint32_t PassSizer::affordable(FilmPlace left, double seconds) const {
  double count = 0.0;
  for_each_stretch(left, limits_.lane_groups, [&](std::size_t index, double groups) {
    const double cost = cost_at(index) * gpu::kWorkgroupSize;
    const double some = std::min(groups, seconds / cost);
    count += some;
    seconds -= some * cost;
    return some == groups;
  });
  return static_cast<std::uint32_t>(count);
}

}  // namespace etendue
