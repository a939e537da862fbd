#include "gpu/pass_sizer.h"

#include <algorithm>

#include "gpu_types.h"

namespace etendue {

void PassSizer::measured(double paths, double seconds) {
  if (!(seconds > 0.0)) return;
  const double rate = paths / seconds;
  // The first measurement may include a compilation, or lack the dispatch that did, so it only sizes the next one.
  if (measurements_ > 0) recent_[(measurements_ - 1) % kRecent] = rate;
  const std::size_t known = std::min(measurements_, kRecent);
  ++measurements_;
  const double slowest = known > 0 ? *std::min_element(recent_.begin(), recent_.begin() + known) : rate;
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

std::uint32_t PassSizer::groups(std::uint32_t left, std::uint32_t paths) const {
  const auto most = static_cast<std::uint32_t>(std::min<std::uint64_t>(left, limits_.most_groups));
  if (limits_.fixed_groups > 0) return std::min(limits_.fixed_groups, most);
  const auto wanted = static_cast<std::uint32_t>(size() / paths);
  const std::uint32_t groups = std::min(std::max(wanted, limits_.lane_groups), most);
  const std::uint32_t chunks = (left + groups - 1) / groups;
  return (left + chunks - 1) / chunks;  // all of equal size
}

std::uint32_t PassSizer::paths(std::uint32_t left, std::uint32_t groups) const {
  return std::clamp(static_cast<std::uint32_t>(size() / groups), 1u, left);
}

std::uint32_t PassSizer::lane_groups(std::uint32_t groups) const {
  const std::uint32_t rounds = (groups + limits_.lane_groups - 1) / limits_.lane_groups;
  return (groups + rounds - 1) / rounds;
}

// Groups of 64 paths in a dispatch.
double PassSizer::size() const {
  const std::uint64_t in_a_row = std::uint64_t{limits_.lane_groups} * limits_.paths_per_lane;
  const auto most = static_cast<double>(std::min(limits_.most_groups, in_a_row));
  return std::clamp(limits_.seconds * rate_ / gpu::kWorkgroupSize, 1.0, most);
}

}  // namespace etendue
