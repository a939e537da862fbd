#pragma once
/// The sample indices that remain to be rendered.

#include <cstdint>
#include <mutex>
#include <optional>

#include "image/sample_ranges.h"
#include "render/renderer.h"

namespace etendue {

/// The indices of `a` that are not in `b`. Both are canonical, and so is the result.
SampleRanges difference(const SampleRanges& a, const SampleRanges& b);
/// The `count` smallest indices of `ranges`, or all if there are fewer.
SampleRanges first_samples(const SampleRanges& ranges, std::uint64_t count);

/// Hands out samples in order. Thread-safe.
class SampleQueue {
 public:
  explicit SampleQueue(SampleRanges todo) : todo_(std::move(todo)) {}

  /// The next samples, at most `limit` > 0, as one range; nothing if none are left.
  std::optional<SampleRange> take(std::uint32_t limit);
  /// Takes back samples that were taken but not rendered.
  void give_back(SampleRange range);
  std::uint64_t left() const;

 private:
  mutable std::mutex mutex_;
  SampleRanges todo_;
};

}  // namespace etendue
