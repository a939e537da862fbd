#include "image/sample_ranges.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include <fmt/format.h>

namespace etendue {

std::string to_text(const SampleRanges& ranges) {
  std::string text;
  for (const auto& [begin, end] : ranges) text += fmt::format("{}{}:{}", text.empty() ? "" : ",", begin, end);
  return text;
}

std::optional<SampleRanges> parse_sample_ranges(std::string_view text) {
  SampleRanges ranges;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    std::pair<std::uint32_t, std::uint32_t> range;
    const auto first = std::from_chars(at, end, range.first);
    if (first.ec != std::errc{} || first.ptr == end || *first.ptr != ':') return {};
    const auto second = std::from_chars(first.ptr + 1, end, range.second);
    if (second.ec != std::errc{}) return {};
    ranges.push_back(range);
    at = second.ptr;
    if (at != end && *at++ != ',') return {};
  }
  // Comparing with the canonical text refuses leading zeros, trailing commas and unsorted ranges all at once.
  if (!is_canonical(ranges) || to_text(ranges) != text) return {};
  return ranges;
}

bool is_canonical(const SampleRanges& ranges) {
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (ranges[i].first >= ranges[i].second) return false;
    if (i > 0 && ranges[i - 1].second >= ranges[i].first) return false;
  }
  return true;
}

SampleRanges canonical(SampleRanges ranges) {
  std::erase_if(ranges, [](const auto& range) { return range.first >= range.second; });
  std::sort(ranges.begin(), ranges.end());
  SampleRanges joined;
  for (const auto& range : ranges) {
    if (!joined.empty() && joined.back().second >= range.first) {
      joined.back().second = std::max(joined.back().second, range.second);
    } else {
      joined.push_back(range);
    }
  }
  return joined;
}

std::uint64_t sample_count(const SampleRanges& ranges) {
  std::uint64_t count = 0;
  for (const auto& [begin, end] : ranges) count += end - begin;
  return count;
}

std::uint32_t lowest_sample(const SampleRanges& ranges) {
  return ranges.empty() ? std::numeric_limits<std::uint32_t>::max() : ranges.front().first;
}

}  // namespace etendue
