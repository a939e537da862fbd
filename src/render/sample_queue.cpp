#include "render/sample_queue.h"

#include <algorithm>

namespace etendue {

SampleRanges difference(const SampleRanges& a, const SampleRanges& b) {
  SampleRanges result;
  for (auto [begin, end] : a) {
    for (const auto& [cut_begin, cut_end] : b) {
      if (cut_end <= begin || cut_begin >= end) continue;
      if (cut_begin > begin) result.emplace_back(begin, cut_begin);
      begin = std::min(cut_end, end);
    }
    if (begin < end) result.emplace_back(begin, end);
  }
  return result;
}

SampleRanges first_samples(const SampleRanges& ranges, std::uint64_t count) {
  SampleRanges result;
  for (const auto& [begin, end] : ranges) {
    if (count == 0) break;
    const auto taken = static_cast<std::uint32_t>(std::min<std::uint64_t>(count, end - begin));
    result.emplace_back(begin, begin + taken);
    count -= taken;
  }
  return result;
}

std::optional<SampleRange> SampleQueue::take(std::uint32_t limit) {
  const std::lock_guard lock(mutex_);
  if (todo_.empty()) return {};
  auto& [begin, end] = todo_.front();
  const SampleRange taken{begin, begin + std::min(limit, end - begin)};
  begin = taken.end;
  if (begin == end) todo_.erase(todo_.begin());
  return taken;
}

void SampleQueue::give_back(SampleRange range) {
  if (range.begin >= range.end) return;
  const std::lock_guard lock(mutex_);
  todo_.emplace_back(range.begin, range.end);
  todo_ = canonical(std::move(todo_));
}

std::uint64_t SampleQueue::left() const {
  const std::lock_guard lock(mutex_);
  return sample_count(todo_);
}

}  // namespace etendue
